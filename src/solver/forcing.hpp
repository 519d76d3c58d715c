/// The tolerances of Newton's linear systems: no tighter than the progress of the iteration warrants.
#pragma once

#include <array>

namespace pliant {

/// Relative tolerances ("forcing terms") of inexact Newton methods (Dembo, Eisenstat, Steihaug 1982; Eisenstat, Walker
/// 1996, "Choosing the forcing terms in an inexact Newton method").
///
/// The residual after a full step is the residual of the linear system plus the nonlinear remainder that the linear
/// model neglects. The remainder is known from earlier stages: stages vary smoothly, so the k-th iteration neglects
/// about as much as the k-th iteration of the last stage. The linear residual is kept to a fraction of this remainder,
/// and never below a fraction of the stage's target.
class Forcing {
 public:
  /// The tolerance for the iteration (from 0) that starts at `residual`; `target`: the residual to be reached [N].
  double tolerance(int iteration, double residual, double target);
  /// Records the residual after the full step of the iteration for which `tolerance` was called last [N].
  void observe(double residual);
  /// Forgets all observations, for iterations that the last ones cannot predict.
  void forget() { left_out_.fill(unknown); }

 private:
  static constexpr double unknown = -1.0;
  static constexpr int num_remembered = 4;

  std::array<double, num_remembered> left_out_{unknown, unknown, unknown,
                                               unknown};  // as a fraction of the previous residual
  int iteration_ = 0;
  double residual_ = 0.0;
  double tolerance_ = 0.0;
};

}  // namespace pliant
