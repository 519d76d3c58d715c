/// How an equilibrium is found where there is no inertia.
#pragma once

#include "petsc/handle.hpp"
#include "solver/iteration.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Without inertia there may be no minimum nearby, and still an equilibrium. One attempt after another, until one
/// arrives: a few iterations of Newton's method to a minimum nearby; a few to any equilibrium nearby, on the residual
/// and whatever the signs of the Hessian's eigenvalues; and, where steps cut short do not help, a descent to a minimum
/// far away, to which the body snaps. The first two in the order that led to the equilibrium before.
///
/// Invariants:
/// - Apart from a descent, all attempts of a stage together take at most the given number of iterations, but that one
///   which is converging may finish.
/// - Between stages the aim of the objective is the usual one, and nothing is held.
///
/// Collective.
class EquilibriumSearch {
 public:
  /// `relative`: tolerance of the residual. The references outlive the object.
  EquilibriumSearch(Objective& objective, Iteration& iteration, SolverStatistics& statistics, double relative);

  /// From the guess in q, or from another one if that is not nullptr.
  StageReport seek(Vec q, Vec second_guess, int max_iterations);
  /// What the stage's guess should be good for: the equilibrium before may have been one that is no minimum.
  Aim first_aim() const { return prefers_following_ ? Aim::any_equilibrium : objective_.usual_aim(); }
  /// Forgets what earlier stages have taught.
  void forget();

 private:
  /// The work of all attempts of a stage.
  struct Work {
    StageReport report;  ///< of the last attempt; its numbers of iterations are those of all
    int limit = 0;
    bool is_over() const { return report.outcome != StageOutcome::retry; }
    int left() const { return limit - report.newton_iterations; }
  };
  /// Starts from the guess, at most so many iterations; whether nothing more needs to be tried.
  bool attempt(Vec q, Vec guess, Aim aim, int max_iterations, Work& work);
  /// Descends from q to where the potential is nearly least, by solutions that are held near the one before; to resume
  /// from when iterations have run out. In the report only iterations count.
  StageReport descend(Vec q, int max_iterations);

  Objective& objective_;
  Iteration& iteration_;
  SolverStatistics& statistics_;
  double relative_;
  int trouble_ = 0;                 // grows with each stage for which no equilibrium is found, falls with each other
  bool prefers_following_ = false;  // the equilibrium before was one without a minimum
};

}  // namespace pliant
