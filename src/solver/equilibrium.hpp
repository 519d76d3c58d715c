/// The search for an equilibrium of a stage without inertia.
#pragma once

#include "petsc/handle.hpp"
#include "solver/convergence.hpp"
#include "solver/iteration.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Without inertia there may be an equilibrium but no minimum nearby. The search makes one attempt after another until
/// one converges: a few iterations of Newton's method to a nearby minimum; where bodies are slender, a few whole steps
/// to a stable equilibrium, whether or not they lower the potential; a few to any nearby equilibrium, on the residual
/// and regardless of the signs of the Hessian's eigenvalues; and, if shorter steps do not help, a descent to a distant
/// minimum, to which the body snaps. The attempt that found the previous equilibrium is made first.
///
/// Invariants:
/// - Apart from a descent, all attempts of a stage together take at most the given number of iterations, except that an
///   attempt that is converging may finish.
/// - Between stages the aim of the objective is the usual one, and the proximal term is released.
///
/// Collective.
class EquilibriumSearch {
 public:
  /// `relative`: tolerance of the residual. The references outlive the object.
  EquilibriumSearch(Objective& objective, Iteration& iteration, SolverStatistics& statistics, double relative,
                    Slenderness slenderness = Slenderness::none);

  /// Starts from the guess in q, and also from the second guess if it is not nullptr.
  StageReport seek(Vec q, Vec second_guess, int max_iterations);
  /// Takes q to equilibria under forces that hold the displacements near q, ever more softly, and freezes coefficients
  /// at each. Bodies that only friction holds need the pressure there: at a guess where nothing presses there is no
  /// friction. A failure has a reason only if nothing holds them.
  StageReport hold_softly(Vec q, int max_iterations);
  /// The aim for which the stage's guess is chosen; the previous equilibrium may not have been a minimum.
  Aim first_aim() const { return prefers_following_ ? Aim::any_equilibrium : objective_.usual_aim(); }
  /// Forgets what was learned from earlier stages.
  void forget();

 private:
  /// The work of all attempts of a stage.
  struct Work {
    StageReport report;  ///< of the last attempt, with the iterations of all attempts
    int limit = 0;
    bool is_over() const { return report.outcome != StageOutcome::retry; }
    int left() const { return limit - report.newton_iterations; }
  };
  /// Runs at most this many iterations from the guess; returns whether nothing more needs to be tried.
  bool attempt(Vec q, Vec guess, Aim aim, int max_iterations, Work& work);
  /// Descends from q towards a minimum of the potential, by solutions each held near the previous one. Can be resumed
  /// when the iterations have run out. Only the iterations in the report have a meaning.
  StageReport descend(Vec q, int max_iterations);

  Objective& objective_;
  Iteration& iteration_;
  SolverStatistics& statistics_;
  double relative_;
  Slenderness slenderness_;
  int trouble_ = 0;                   // grows with each stage without an equilibrium, falls with each other stage
  bool prefers_following_ = false;    // the previous equilibrium was not a minimum
  bool prefers_whole_steps_ = false;  // it was found by these
};

}  // namespace pliant
