/// Fixed points of maps whose evaluation costs a solve (Anderson acceleration).
#pragma once

#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// Finds x = g(x) by Anderson acceleration, also called Anderson mixing (Walker & Ni 2011, Anderson acceleration for
/// fixed-point iterations): with f_k = g(x_k) - x_k, and the differences dF, dG of the last f and g,
///
///     x_{k+1} = g_k - dG gamma,   gamma = argmin |f_k - dF gamma|
///
/// On a linear map of few dimensions it is as fast as GMRES, where the plain iteration x_{k+1} = g_k converges as the
/// powers of the map's norm.
class FixedPoint {
 public:
  /// Starts from x. Collective.
  explicit FixedPoint(Vec x);

  /// x_{k+1} - g, for g = g(x) at the last x; valid until the next call. Collective.
  Vec step(Vec g);
  /// Sets the x at which g is evaluated next: g + `step`, or a shorter step. Collective.
  void take(Vec x);

 private:
  void solve_least_squares(std::vector<double>& gamma) const;

  Handle<Vec> x_, f_, g_, step_;
  std::vector<Handle<Vec>> dF_, dG_;  // newest last
  double least_ = 0.0;                // |f| so far
  bool is_first_ = true;
};

}  // namespace pliant
