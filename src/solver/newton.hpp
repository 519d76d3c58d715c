/// The solver of a stage: Newton's method on the incremental potential, or on the residual alone, through SNES.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"
#include "solver/equilibrium.hpp"
#include "solver/failed_stage.hpp"
#include "solver/guess.hpp"
#include "solver/newton_loop.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "time/stage.hpp"

#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace pliant {

/// How the solver solves an equation and why, in words for the log.
std::string describe(const StageEquation& equation, LinearKind linear);

/// Newton with the Hessian (tangent stiffness), a line search on the potential, or on a merit of the residual where
/// there is none, and a fallback sequence for trouble. Each part has its own header:
///
/// - GuessSearch: where a stage starts.
/// - NewtonLoop: the iteration itself, with Convergence (when it ends), LinearSystem (its directions), FactorPolicy
///   (when a factor is kept), Escalation (the fallback sequence) and LineSearch (how far it goes).
/// - EquilibriumSearch and solve_residual: several runs of the loop, where one may not do.
///
/// Every rank takes the same decisions: all of them rest on reduced numbers.
///
/// Invariants:
/// - A stage that is not solved leaves no trace in the next one but what `forget` forgets: an aged factor, and what
///   was learned of tolerances, shifts and equilibria.
/// - What the last stage was is kept only if it failed, for `examine`.
class NewtonSolver {
 public:
  /// `equation` outlives the solver. PETSc options -snes_..., -ksp_..., -pc_... override. Collective.
  NewtonSolver(StageEquation& equation, const NewtonOptions& options, LinearKind linear);

  /// Solves the stage of configurations, as a StageSolve does: from the guess in q, or from q0 + dt v0 where that
  /// lowers the potential (or the merit) further. Collective.
  StageReport solve(const StagePoint& stage, Vec q);

  /// Looks closely at the last stage, if it could not be solved; before anything else is asked of the equation, whose
  /// other state (pressures) it leaves at the stage's last iterate. Collective.
  std::optional<FailedStage> examine();

  /// Forgets what earlier stages have taught: the next one is solved as a new solver would.
  void forget();

  /// Calls `watcher` at each iteration of Newton's method. Collective.
  void watch(std::function<void(const StageProgress&)> watcher) { loop_.log().watch(std::move(watcher)); }

  const SolverStatistics& statistics() const { return statistics_; }

 private:
  /// A stage that could not be solved: where its iteration ended.
  struct Failure {
    Handle<Vec> q;
    double time = 0.0, dt = 0.0;
  };

  /// The same in the unknowns of the equation.
  StageReport solve_for_unknowns(const StagePoint& stage, Vec q);
  /// By as many runs of Newton's iteration as it takes.
  StageReport iterate(Vec q);
  /// Solves again, with coefficients frozen at the solution, until it stays one.
  void settle_coefficients(Vec q, StageReport& report);
  /// Whether q solves the stage with the coefficients as they are.
  bool is_settled(Vec q);
  /// Without inertia there may be an equilibrium that is no minimum.
  bool may_follow() const { return objective_.is_static() && equation_.symmetry() != Symmetry::unsymmetric; }

  StageEquation& equation_;
  NewtonOptions options_;
  SolverStatistics statistics_;
  Handle<Vec> unknowns_, trial_;
  Objective objective_;
  NewtonLoop loop_;
  GuessSearch guesses_;
  EquilibriumSearch equilibria_;
  std::optional<Failure> failure_;
};

}  // namespace pliant
