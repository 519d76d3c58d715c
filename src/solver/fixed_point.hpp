/// Fixed points of maps that cost a solve.
#pragma once

#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// Finds x = g(x) by Anderson's mixing (Walker & Ni 2011, Anderson acceleration for fixed-point iterations): with
/// f_k = g(x_k) - x_k, and the differences dF, dG of the last f and g,
///
///     x_{k+1} = g_k - dG gamma,   gamma = argmin |f_k - dF gamma|
///
/// on a linear map of few dimensions as fast as GMRES, where x_{k+1} = g_k converges as the powers of its norm.
class FixedPoint {
 public:
  /// From x. Collective.
  explicit FixedPoint(Vec x);

  /// x_{k+1} - g of the g found for the last x; valid until the next call. Collective.
  Vec step(Vec g);
  /// The x for which g is found next: what `step` says, or less. Collective.
  void take(Vec x);

 private:
  void solve_least_squares(std::vector<double>& gamma) const;

  Handle<Vec> x_, f_, g_, step_;
  std::vector<Handle<Vec>> dF_, dG_;  // newest last
  double least_ = 0.0;                // |f| so far
  bool is_first_ = true;
};

}  // namespace pliant
