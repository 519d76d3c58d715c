/// What is known of a stage that Newton's method could not solve, for the post-mortem of a run.
#pragma once

#include "petsc/handle.hpp"

#include <optional>
#include <vector>

namespace pliant {

class Objective;

/// An iteration: where it led and what it took.
struct NewtonIteration {
  enum class Hessian { exact, projected, shifted };
  double residual = 0.0;     ///< norm at its end; of the first entry, at the starting guess [N]
  double step_length = 0.0;  ///< as a part of Newton's step; of the first entry 0
  int linear_iterations = 0;
  Hessian hessian = Hessian::exact;
};

/// Vectors hold three entries per node; the same numbers on every rank.
struct FailedStage {
  double time = 0.0;            ///< at which its loads are taken [s]
  double dt = 0.0;              ///< its length [s]
  double tolerance = 0.0;       ///< a residual that would have been small enough [N]
  double force_scale = 0.0;     ///< sum of the norms of the forces that balance; 0: the guess was beyond a barrier [N]
  double rounding_floor = 0.0;  ///< size of the rounding errors of the residual [N]
  bool lacks_memory = false;    ///< the linear solver did
  std::vector<NewtonIteration> iterations;

  /// Along the last direction from where the iteration ended; no sample if there was none.
  enum class Measure { potential, merit };
  struct Sample {
    double length = 0.0;  ///< as a part of Newton's step; below 0: against it
    double change = 0.0;  ///< of the measure [J]; +inf beyond a barrier
  };
  Measure measure = Measure::potential;  ///< what a line search is to lower
  std::vector<Sample> profile;           ///< by rising lengths
  std::optional<double> slope;           ///< of the potential, r . d: what the profile must show at 0 [J]
  double inversion = 0.0;                ///< length at which a tetrahedron is flat; may be +inf

  Handle<Vec> displacement;  ///< where the iteration ended [m]
  Handle<Vec> residual;      ///< there; zero on prescribed entries, NaN beyond a barrier [N]
  Handle<Vec> direction;     ///< Newton's step there; zero if there was none [m]
};

/// What the objective is at q, where the iteration ended, and along the last direction from there, d = -y; `y` is
/// nullptr if there was none. Whoever ran the iteration adds its time, tolerances and iterations. Collective.
FailedStage look_along_direction(Objective& objective, Vec q, Vec y);

}  // namespace pliant
