/// Newton's iteration as seen by searches that run it several times.
#pragma once

#include "petsc/handle.hpp"
#include "solver/objective.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Runs of Newton's iteration on the objective of a stage. Collective.
class Iteration {
 public:
  virtual ~Iteration() = default;

  /// Prepares a run from q that is independent of earlier ones: the forces that must balance are those at q.
  virtual void begin(Vec q, Aim aim) = 0;
  /// Prepares another run from the guess of the stage, now in q: the forces that must balance are those of the guess.
  virtual void begin_again(Vec q) = 0;
  /// Iterates from q to a solution, or as far as possible. Another run continues where this one has ended.
  virtual StageReport run(Vec q) = 0;
  /// Likewise, with at most this many iterations.
  virtual StageReport run(Vec q, int max_iterations) = 0;

  /// Whether the last run reached its limit of iterations while converging.
  virtual bool is_converging() const = 0;
  /// Whether the last factorized Hessian has as many negative eigenvalues as that of a stable state.
  virtual bool is_stable(Vec q) = 0;
  /// Discards the current factor, which is of no use for the next run.
  virtual void renew_factor() = 0;
  /// Mean of the absolute diagonal of the Hessian at q.
  virtual double stiffness(Vec q) = 0;
  /// Sets a residual that ends the next runs although it is not yet that of a solution [N]; 0: none.
  virtual void accept(double residual) = 0;
};

}  // namespace pliant
