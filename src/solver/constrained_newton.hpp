/// Newton's method where constraints tie displacements to one another.
#pragma once

#include "energy/equation/constrained_equation.hpp"
#include "solver/newton.hpp"

namespace pliant {

/// Solves in the unknowns that the constraints leave and gives back configurations that fulfil them to rounding.
class ConstrainedNewton {
 public:
  /// As NewtonSolver; `map` outlives the solver too. Collective.
  ConstrainedNewton(StageEquation& equation, ConstraintMap& map, const NewtonOptions& options, LinearKind linear);

  /// As NewtonSolver::solve. Collective.
  StageReport solve(const StagePoint& stage, Vec q);

  /// As NewtonSolver::examine. Collective.
  std::optional<FailedStage> examine() { return solver_.examine(); }

  /// As NewtonSolver::forget.
  void forget() { solver_.forget(); }

  /// As NewtonSolver::watch.
  void watch(std::function<void(const StageProgress&)> watcher) { solver_.watch(std::move(watcher)); }

  const StageEquation& equation() const { return equation_; }
  const SolverStatistics& statistics() const { return solver_.statistics(); }

 private:
  ConstraintMap& map_;
  ConstrainedEquation equation_;
  NewtonSolver solver_;
  Handle<Vec> y_;
};

}  // namespace pliant
