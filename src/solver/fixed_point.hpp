/// Fixed points of maps whose evaluation costs a solve (Anderson acceleration).
#pragma once

#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// Finds x = g(x) by Anderson acceleration, also called Anderson mixing (Walker & Ni 2011, Anderson acceleration for
/// fixed-point iterations): with f_k = g(x_k) - x_k, and the differences dF, dG of the last f and g,
///
///     x_{k+1} = g_k - dG gamma - (1 - m) (f_k - dF gamma),   gamma = argmin |f_k - dF gamma|
///
/// with the mixing m = 1, until the error grows instead: then the differences are discarded and m is halved. Without
/// that a map with a kink may lead from one side to the other and back for ever.
///
/// On a linear map of few dimensions it is as fast as GMRES, where the plain iteration x_{k+1} = g_k converges as the
/// powers of the map's norm.
class FixedPoint {
 public:
  /// Starts from x. Collective.
  explicit FixedPoint(Vec x);

  /// x_{k+1} - g, for g = g(x) at the last x; valid until the next call. Collective.
  Vec step(Vec g);
  /// |g(x) - x| of the last step, relative to that of the first one.
  double error() const { return size_ / first_; }
  /// Sets the x at which g is evaluated next: g + `step`, or a shorter step. Collective.
  void take(Vec x);

 private:
  void solve_least_squares(std::vector<double>& gamma) const;

  Handle<Vec> x_, f_, g_, step_;
  std::vector<Handle<Vec>> dF_, dG_;  // newest last
  double least_ = 0.0;                // |f| since the differences were discarded
  double first_ = 0.0, size_ = 0.0;   // |f| of the first step and of the last
  double mixing_ = 1.0;
  bool is_first_ = true;
};

}  // namespace pliant
