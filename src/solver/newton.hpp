/// The solver of a stage: Newton's method on the incremental potential, or on the residual alone, with PETSc's SNES.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"
#include "solver/coefficient_search.hpp"
#include "solver/equilibrium.hpp"
#include "solver/failed_stage.hpp"
#include "solver/guess.hpp"
#include "solver/newton_loop.hpp"
#include "solver/objective.hpp"
#include "solver/root_search.hpp"
#include "solver/statistics.hpp"
#include "solver/tangent_system.hpp"
#include "time/stage.hpp"

#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace pliant {

/// Describes for the log how the solver solves an equation, and why.
std::string describe(const StageEquation& equation, LinearKind linear);

/// Newton's method with the Hessian (tangent stiffness), a line search on the potential or, if there is none, on a
/// merit function of the residual, and a fallback sequence for iterations without a usable direction. Each part has its
/// own header:
///
/// - GuessSearch: the starting guess of a stage.
/// - NewtonLoop: the iteration itself, with Convergence (the test of convergence), LinearSystem (the directions),
///   FactorPolicy (the lifetime of a factor), Escalation (the fallback sequence) and LineSearch (the step length).
/// - EquilibriumSearch and RootSearch: several runs of the loop, if one may not be enough.
/// - CoefficientSearch: coefficients that follow the solution.
///
/// Every rank takes the same decisions, because all of them depend on reduced numbers.
///
/// Invariants:
/// - A stage that is not solved leaves no trace in the next one except what `forget` clears: an aged factor, and what
///   was learned about tolerances, shifts and equilibria.
/// - The last stage is kept only if it failed, for `examine`.
class NewtonSolver {
 public:
  /// `equation` outlives the solver. PETSc options -snes_..., -ksp_..., -pc_... override. Collective.
  NewtonSolver(StageEquation& equation, const NewtonOptions& options, LinearKind linear);

  /// Solves a stage given in configurations, as a StageSolve does, from the guess in q or from a better one that
  /// GuessSearch finds. Collective.
  StageReport solve(const StagePoint& stage, Vec q);

  /// Examines the last stage if it could not be solved. To be called before anything else uses the equation, whose
  /// other state (pressures) it leaves at the stage's last iterate. Collective.
  std::optional<FailedStage> examine();

  /// Forgets what was learned from earlier stages: the next one is solved as by a new solver.
  void forget();

  /// Makes each iteration of Newton's method call `watcher`. Collective.
  void watch(std::function<void(const StageProgress&)> watcher) { loop_.log().watch(std::move(watcher)); }

  const SolverStatistics& statistics() const { return statistics_; }

  /// After a stage was solved, and until the next one: its equation, the unknowns that solve it, and the linear system
  /// of its tangent.
  StageEquation& equation() { return equation_; }
  Vec unknowns() const { return unknowns_.get(); }
  TangentSystem& tangent() { return tangent_; }

 private:
  /// A stage that could not be solved, with its last iterate.
  struct Failure {
    Handle<Vec> q;
    double time = 0.0, dt = 0.0;
  };

  /// Likewise, in the unknowns of the equation.
  enum class Guess { best, given };
  StageReport solve_for_unknowns(const StagePoint& stage, Vec q, Guess which);
  /// Runs Newton's iteration, several times if necessary.
  /// Whether a stage without inertia has displacements beyond NewtonOptions::reach.
  bool has_left(Vec q);
  StageReport iterate(Vec q, int max_iterations);
  /// Once more from the guess after a failure without inertia, with the drag of a state that is held softly near it;
  /// where no terms refreeze, what failed.
  StageReport iterate_with_drag(Vec q, Vec guess, const StageReport& failed);
  /// Whether there may be an equilibrium that is not a minimum: in stages without inertia.
  bool may_follow() const { return objective_.is_static() && is_symmetric(equation_.symmetry()); }

  StageEquation& equation_;
  NewtonOptions options_;
  SolverStatistics statistics_;
  Handle<Vec> unknowns_;
  Objective objective_;
  NewtonLoop loop_;
  GuessSearch guesses_;
  EquilibriumSearch equilibria_;
  RootSearch roots_;
  CoefficientSearch coefficients_;
  TangentSystem tangent_;
  std::optional<Failure> failure_;
  bool needs_drag_ = false;  // an earlier stage was found with the drag of a state that is held softly, or not at all
};

}  // namespace pliant
