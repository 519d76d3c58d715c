/// What several kinds of loads have in common.
#pragma once

#include "input/config.hpp"

#include <optional>

namespace pliant {

/// The value of a load that has a direction of its own; nullptr for pressures and foundations.
const VectorExpression* vector_of(const LoadConfig& load);

/// Coefficients of springs and dashpots, in the units of the kind of foundation; 0 where there are none.
struct FoundationCoefficients {
  double spring = 0;
  double dashpot = 0;
};

/// Nothing if the load is not a foundation.
std::optional<FoundationCoefficients> foundation_of(const LoadConfig& load);

/// The first load or cavity whose pressure or density is not zero at time 0, at the origin; nothing if there is none.
std::optional<Location> load_at_once(const Config& config);

}  // namespace pliant
