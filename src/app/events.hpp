/// Times at which what drives the bodies changes abruptly.
#pragma once

#include "app/config.hpp"

#include <string>
#include <vector>

namespace pliant {

/// All formulas that act on the bodies or move them after the start.
std::vector<const Expression*> driving_formulas(const Config& config);

/// Where steps end, and methods with past states start anew: the input's `time.events`, and the times at which its
/// formulas of t have kinks or jumps (Expression::kinks).
struct Events {
  std::vector<double> times;          ///< ascending, in (0, end) [s]
  std::vector<std::string> notices;   ///< which of them were found
  std::vector<std::string> warnings;  ///< kinks that are too many to be events
};

/// Kinks are looked for at quarters of a step, or at a thousandth of the run if that is less. Of a static problem there
/// are none.
Events events_of(const Config& config);

}  // namespace pliant
