#include "input/analysis.hpp"

#include "input/keys.hpp"

namespace pliant {

Analysis analysis_of(const Config& config) {
  if (config.time.method.value == static_method) return Analysis::static_equilibrium;
  return config.time.method.value == quasistatic_method ? Analysis::quasistatic : Analysis::dynamic;
}

const Method* integrator_of(const Config& config) {
  if (analysis_of(config) == Analysis::quasistatic) return find_method("backward-euler");
  return method_of(config.time);
}

}  // namespace pliant
