#include "input/analysis.hpp"

namespace pliant {
namespace {

struct NameOf {
  std::string operator()(const MethodConfig::Unknown&) const { return {}; }
  std::string operator()(const Method& method) const { return method.name; }
  std::string operator()(const MethodConfig::PetscIntegrator& integrator) const { return "petsc:" + integrator.name; }
  std::string operator()(const MethodConfig::Quasistatic&) const { return "quasistatic"; }
  std::string operator()(const MethodConfig::Static&) const { return "static"; }
};

}  // namespace

Analysis analysis_of(const TimeConfig& time) {
  if (std::holds_alternative<MethodConfig::Static>(time.method.kind)) return Analysis::static_equilibrium;
  return std::holds_alternative<MethodConfig::Quasistatic>(time.method.kind) ? Analysis::quasistatic
                                                                             : Analysis::dynamic;
}

Analysis analysis_of(const Config& config) {
  return analysis_of(config.time);
}

std::string method_name(const MethodConfig& method) {
  return std::visit(NameOf{}, method.kind);
}

const Method* integrator_of(const Config& config) {
  if (analysis_of(config) == Analysis::quasistatic) return find_method("backward-euler");
  return method_of(config.time);
}

}  // namespace pliant
