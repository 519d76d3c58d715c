/// What several kinds of loads have in common.
#pragma once

#include "input/config.hpp"

#include <optional>
#include <string>

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

/// A load that is not zero at time 0, and formulas by which it grows to its size until the end of the run.
struct LoadAtOnce {
  Location where;
  std::string grown;  ///< the value of its key, as in YAML
};

/// The first load or cavity whose pressure or density is not zero at time 0, at the origin; nothing if there is none.
std::optional<LoadAtOnce> load_at_once(const Config& config);

}  // namespace pliant
