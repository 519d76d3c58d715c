/// A function of the positions of a few points, to second order, and its projection to a positive-semidefinite Hessian.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cstddef>

namespace pliant {

/// Value, gradient and Hessian of a function of N points. In units of the value, per metre and per square metre.
template <int N>
struct Expansion {
  double value = 0.0;
  std::array<Vector3<double>, N> gradient{};
  std::array<Tensor3<double>, N * N> blocks{};  ///< the Hessian: block (i, j) is d2/dx_i dx_j

  Tensor3<double>& block(int i, int j) { return blocks[static_cast<std::size_t>(N * i + j)]; }
  const Tensor3<double>& block(int i, int j) const { return blocks[static_cast<std::size_t>(N * i + j)]; }
};

/// Replaces negative eigenvalues of the Hessian by zero: the nearest positive-semidefinite matrix in the Frobenius
/// norm. A Hessian without negative eigenvalues, or one that is not finite, stays as it is, bit by bit.
void project_to_positive_semidefinite(Expansion<4>& f);

}  // namespace pliant
