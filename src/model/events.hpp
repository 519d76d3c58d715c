/// Times at which what drives the bodies changes abruptly.
#pragma once

#include "input/config.hpp"

#include <array>
#include <vector>

namespace pliant {

/// A formula that acts on the bodies or moves them after the start.
struct DrivingFormula {
  enum class Kind { force, motion };
  const Expression* formula = nullptr;
  Location where;  ///< of the entry of the input that it belongs to
  Kind kind = Kind::force;
};
std::vector<DrivingFormula> driving_formulas(const Config& config);

/// Where steps end, and methods with past states start anew: the input's `time.events`, and the times at which its
/// formulas of t have kinks or jumps (Expression::kinks).
struct Events {
  std::vector<double> times;            ///< ascending, in (0, end) [s]
  std::vector<Diagnostic> diagnostics;  ///< which of them were found, or a warning that there are too many kinks
};

/// Kinks are looked for at quarters of a step, or at a thousandth of the run if that is less. Of a static problem there
/// are none.
Events events_of(const Config& config);

/// Warnings of prescribed motion whose kinks are at another time at each place, which therefore are no events. Looked
/// for at 27 places of a box: `bounds` are xmin ymin zmin xmax ymax zmax of the bodies [m].
std::vector<Diagnostic> warnings_about_moving_kinks(const Config& config, const std::array<double, 6>& bounds);

}  // namespace pliant
