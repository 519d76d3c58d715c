/// The line along Newton's direction, in vectors.
#pragma once

#include "petsc/handle.hpp"
#include "petsc/work_vector.hpp"
#include "solver/line_search.hpp"
#include "solver/linear_system.hpp"
#include "solver/objective.hpp"

namespace pliant {

/// q + alpha d with d = -K^-1 r. Residuals are evaluated through SNES, which counts them. Collective.
///
/// Invariant: q, r and the vector from which d was made do not change until `take`.
class NewtonLine final : public SearchLine {
 public:
  /// The references outlive the object, and so does the SNES.
  NewtonLine(Objective& objective, LinearSystem& system, SNES snes, SolverStatistics& statistics);

  /// Defines the line from q along -y; `trial` receives its points. `value`: the potential at q, if it is minimised.
  LineStart lay(Vec q, Vec r, Vec y, Vec trial, double value);
  /// Copies the last point of the line to q, and the residual there to r.
  void take(Vec q, Vec r);

  double potential(double alpha) override;
  Residual residual(double alpha) override;
  bool is_admissible() override;
  double merit() override { return objective_.merit().of_residual(r_.get()); }
  double merit_of_correction() override;
  double merit_of_direction() override { return objective_.merit().of_step(d_.get()); }
  double merit_of_nonlinear_part(double alpha) override;

 private:
  void go_to(double alpha);
  /// The first step length to try: at most 1, and short of the step at which a tetrahedron inverts.
  double first_length();

  Objective& objective_;
  LinearSystem& system_;
  SNES snes_;
  SolverStatistics& statistics_;
  Handle<Vec> d_, r_;
  WorkVector correction_;
  Vec q_ = nullptr, trial_ = nullptr;
  double length_ = 0.0;  // step length of the point in trial_
};

}  // namespace pliant
