#include "app/viscosity.hpp"

#include "app/model.hpp"
#include "energy/viscous.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Without a method of ours the exact form, which needs no history.
StrainRate automatic_rate(const Method* method) {
  return method == nullptr ? StrainRate::exact : strain_rate_for(*method);
}

ViscosityVariant law_of(const ViscosityConfig& v, const Method* method) {
  if (v.model == KelvinVoigt::name) return KelvinVoigt{v.shear, v.bulk, v.rate.value_or(automatic_rate(method))};
  return Maxwell{v.shear_modulus, v.bulk_modulus, v.relaxation_time};
}

}  // namespace

bool has_viscosity(const Config& config) {
  return std::ranges::any_of(config.bodies, [](const BodyConfig& body) { return body.viscosity.has_value(); });
}

std::vector<std::unique_ptr<EnergyTerm>> make_viscous_terms(const Config& config, const BodyParts& on) {
  std::vector<std::unique_ptr<EnergyTerm>> terms;
  if (analysis_of(config) == Analysis::static_equilibrium) return terms;
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const auto& viscosity = config.bodies[b].viscosity;
    if (!viscosity) continue;
    const ViscosityVariant law = law_of(*viscosity, integrator_of(config));
    terms.push_back(std::visit(
        [&]<int Order>(const CellGroups<Order>& groups) {
          return make_viscous_term<Order>(law, groups, static_cast<int>(b), on.layout.num_owned_nodes);
        },
        on.cells));
  }
  return terms;
}

}  // namespace pliant
