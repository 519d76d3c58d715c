/// The solution of a stage whose coefficients are frozen at that solution (friction with the pressure that it causes).
#pragma once

#include "petsc/work_vector.hpp"
#include "solver/coupled_system.hpp"
#include "solver/merit.hpp"
#include "solver/newton_loop.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "time/stage.hpp"

#include <optional>

namespace pliant {

/// Finds q that solves the stage with coefficients frozen at q (StageEquation::refreeze), from a solution for others.
/// Two ways take turns:
///
/// - Newton's method on the residual r(q; q) whose coefficients follow q (CoupledSystem). It converges in a few steps
///   from nearby, and may fail where sticking turns into sliding.
/// - Rounds: the stage is solved again with coefficients frozen at its last solution, a minimum of a potential, and the
///   solutions are extrapolated (FixedPoint).
class CoefficientSearch {
 public:
  /// The references outlive the object. Collective.
  CoefficientSearch(Objective& objective, NewtonLoop& loop, SolverStatistics& statistics);

  /// On entry q and `report` are those of a solution; on return those of one with its own coefficients, or `report`
  /// says why there is none. Collective.
  void settle(Vec q, StageReport& report);

 private:
  /// Whether q solves the stage with the coefficients as they are; sets r_ to its residual.
  bool is_settled(Vec q);
  /// The residual r_ at q, where coefficients are frozen, as a part of the drag.
  double missing_part(Vec q);
  /// Steps of Newton's method from q, at which coefficients are frozen, and r_ is the residual, before and after.
  /// Returns whether q is a solution.
  bool step_to_solution(Vec q, StageReport& report);
  /// One of them. Returns the merit of the residual before it [J]; nothing, and q as before, if it does not lower that.
  std::optional<double> step(Vec q, StageReport& report);

  Objective& objective_;
  StageEquation& equation_;
  NewtonLoop& loop_;
  SolverStatistics& statistics_;
  std::optional<CoupledSystem> coupled_;
  Merit merit_;
  WorkVector r_, trial_, trial_residual_, d_, diagonal_;
};

}  // namespace pliant
