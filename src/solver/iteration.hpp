/// Newton's iteration as those see it who look for a solution by several runs of it.
#pragma once

#include "petsc/handle.hpp"
#include "solver/objective.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Runs of Newton's iteration on the objective of a stage. Collective.
class Iteration {
 public:
  virtual ~Iteration() = default;

  /// Prepares a run from q that owes nothing to those before it: the forces that must balance are those at q.
  virtual void begin(Vec q, Aim aim) = 0;
  /// Prepares another run from the guess of the stage, now in q: the forces that must balance are those of the guess.
  virtual void begin_again(Vec q) = 0;
  /// From q, to a solution or as far as it goes. Another run continues where this one has ended.
  virtual StageReport run(Vec q) = 0;
  /// The same with a limit on the number of iterations.
  virtual StageReport run(Vec q, int max_iterations) = 0;

  /// Whether the last run has run out of iterations near its end.
  virtual bool is_converging() const = 0;
  /// Whether the Hessian factorized last has as many negative eigenvalues as a stable state has.
  virtual bool is_stable() const = 0;
  /// The factor at hand is of no use for the next run.
  virtual void renew_factor() = 0;
  /// Mean of the absolute diagonal of the Hessian at q.
  virtual double stiffness(Vec q) = 0;
  /// A residual that ends the next runs although it is no solution [N]; 0: none.
  virtual void accept(double residual) = 0;
};

}  // namespace pliant
