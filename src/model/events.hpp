/// Times at which loads or prescribed motions change abruptly.
#pragma once

#include "input/config.hpp"

#include <array>
#include <vector>

namespace pliant {

/// A formula that loads the bodies or moves them after the start.
struct DrivingFormula {
  enum class Kind { force, motion };
  const Expression* formula = nullptr;
  Location where;  ///< of the entry of the input that it belongs to
  Kind kind = Kind::force;
};
std::vector<DrivingFormula> driving_formulas(const Config& config);

/// Those of them that may change while a simulation runs, in an order that depends on the input's structure alone. Not
/// the flow of a liquid, whose integral over time is computed at the start.
struct ReplaceableFormula {
  Expression* formula = nullptr;
  DrivingFormula::Kind kind = DrivingFormula::Kind::force;
  bool is_of_joint = false;
};
std::vector<ReplaceableFormula> replaceable_formulas(Config& config);

/// Times at which steps end and methods with past states restart: the input's `time.events`, and the times at which its
/// formulas of t have kinks or jumps (Expression::kinks).
struct Events {
  std::vector<double> times;  ///< ascending, in (0, end) [s]
  std::vector<Diagnostic>
      diagnostics;  ///< a note about the times that were found, or a warning that there are too many
};

/// Kinks are searched for in intervals of a quarter of a step, or of a thousandth of the run if that is less. A static
/// problem has none.
Events events_of(const Config& config);

/// Warnings about prescribed motions whose kinks have different times at different positions, and so cannot be events.
/// The search is at 27 points of a box: `bounds` are xmin ymin zmin xmax ymax zmax of the bodies [m].
std::vector<Diagnostic> warnings_about_moving_kinks(const Config& config, const std::array<double, 6>& bounds);

}  // namespace pliant
