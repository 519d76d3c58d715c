/// A law of viscosity of the input.
#pragma once

#include "input/located.hpp"
#include "material/viscosity_registry.hpp"

#include <optional>

namespace pliant {

/// A mechanism of damping.
struct ViscosityConfig {
  ViscosityLaw law;
  std::optional<StrainRate>
      rate;  ///< of laws that have one, instead of the rate in `law`; empty: the best for the method
  Location where;
};

}  // namespace pliant
