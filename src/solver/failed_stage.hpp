/// Information on a stage that Newton's method could not solve, for the post-mortem of a run.
#pragma once

#include "petsc/handle.hpp"

#include <optional>
#include <vector>

namespace pliant {

class Objective;

/// The result and the cost of one iteration.
struct NewtonIteration {
  enum class Hessian { exact, projected, shifted };
  double residual = 0.0;     ///< norm at its end; in the first entry, at the starting guess [N]
  double step_length = 0.0;  ///< as a fraction of the full Newton step; 0 in the first entry
  int linear_iterations = 0;
  Hessian hessian = Hessian::exact;
};

/// Vectors hold three entries per node; all numbers are the same on every rank.
struct FailedStage {
  double time = 0.0;            ///< at which its loads are taken [s]
  double dt = 0.0;              ///< its length [s]
  double tolerance = 0.0;       ///< the residual at which it would have converged [N]
  double force_scale = 0.0;     ///< sum of the norms of the forces that balance; 0: the guess was beyond a barrier [N]
  double rounding_floor = 0.0;  ///< size of the rounding errors of the residual [N]
  bool lacks_memory = false;    ///< the linear solver ran out of memory
  std::vector<NewtonIteration> iterations;

  /// Samples along the last direction from the last iterate; empty if there was no direction.
  enum class Measure { potential, merit };
  struct Sample {
    double length = 0.0;  ///< as a fraction of the full Newton step; negative: opposite to it
    double change = 0.0;  ///< of the measure [J]; +inf beyond a barrier
  };
  Measure measure = Measure::potential;  ///< the function that the line search lowers
  std::vector<Sample> profile;           ///< in ascending order of length
  std::optional<double> slope;           ///< of the potential, r . d: the profile's slope at 0 if all is well [J]
  double inversion = 0.0;                ///< length at which a tetrahedron becomes flat; may be +inf

  Handle<Vec> displacement;  ///< the last iterate [m]
  Handle<Vec> residual;      ///< there; zero on prescribed entries, NaN beyond a barrier [N]
  Handle<Vec> direction;     ///< the full Newton step there; zero if there was none [m]
};

/// Samples the objective at the last iterate q and along the last direction d = -y from there; `y` is nullptr if there
/// was no direction. The caller adds time, tolerances and iterations. Collective.
FailedStage look_along_direction(Objective& objective, Vec q, Vec y);

}  // namespace pliant
