/// The solution of a residual without a potential.
#pragma once

#include "petsc/handle.hpp"
#include "solver/iteration.hpp"
#include "solver/objective.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Several runs of Newton's iteration on a residual, of three kinds.
///
/// - Damped steps, each of which lowers a merit of the residual.
/// - Whole steps, as many as it takes if they converge at all. A whole step may stretch a thin body until its forces
///   are many times those that act on it. The stresses extrapolated along the step are nevertheless close to
///   equilibrium, and the next step removes the stretch; a line search that measures residuals would reject both.
///
/// - Steps of descent, for residuals that are almost gradients: of rigid parts in contact, for instance. With a Hessian
///   that is positive definite, the forces do work along them; they end where that work is done, as if there were a
///   potential. Merits of residuals have minima that do not solve anything where barriers begin to act.
///
/// A stage without inertia begins with whole steps. One with inertia begins with damped steps, or with the kind that
/// solved the last stage; after some stages damped steps are tried again, the later the oftener that was in vain.
/// Damped and whole steps get a few iterations from the guess. Then a few of descent and damped ones take turns, and at
/// last there are damped ones.
///
/// Invariant: what was learned from earlier stages is the kind of steps and for how long it counts, which `forget`
/// clears.
class RootSearch {
 public:
  /// The references outlive the object.
  RootSearch(Objective& objective, Iteration& iteration) : objective_(objective), iteration_(iteration) {}

  /// Solves the stage from the guess in q. On return the aim of the objective is the usual one. Collective.
  StageReport seek(Vec q, int max_iterations);

  void forget() { learned_ = {}; }

 private:
  class Runs;

  Objective& objective_;
  Iteration& iteration_;
  struct Learned {
    Aim preferred = Aim::root;
    int num_left = 0;  // stages that begin with it
    int patience = 2;  // stages that begin with the next kind that helps where damped steps do not
  } learned_;
};

}  // namespace pliant
