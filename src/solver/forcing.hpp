/// How exactly the linear systems of Newton's method are solved: no more exactly than their solution is worth.
#pragma once

#include <array>

namespace pliant {

/// Relative tolerances ("forcing terms") of inexact Newton methods (Dembo, Eisenstat, Steihaug 1982; Eisenstat, Walker
/// 1996, "Choosing the forcing terms in an inexact Newton method").
///
/// The residual after a step is that of the linear solution plus what the linear model leaves out. The second part was
/// seen in the stages before: stages follow each other smoothly, and so the k-th iteration leaves out about what the
/// k-th iteration of the last stage did. The linear residual shall be a part of it, and it need never be less than what
/// the stage is to reach.
class Forcing {
 public:
  /// Of the iteration (from 0) that starts at the residual; `target` is the residual to be reached [N].
  double tolerance(int iteration, double residual, double target);
  /// What the iteration for which `tolerance` was asked last has led to with its full step [N].
  void observe(double residual);
  /// Forgets what was seen: the last iteration says nothing of the next ones.
  void forget() { left_out_.fill(unknown); }

 private:
  static constexpr double unknown = -1.0;
  static constexpr int num_remembered = 4;

  std::array<double, num_remembered> left_out_{unknown, unknown, unknown, unknown};  // as a part of the residual before
  int iteration_ = 0;
  double residual_ = 0.0;
  double tolerance_ = 0.0;
};

}  // namespace pliant
