/// Strain measures of H = grad u, F = I + H, in forms that remain accurate to the last digits when H is small.
///
/// F^T F - I and det F - 1 computed from F lose digits in proportion to the smallness of the strain; these forms lose
/// none. Source:
/// Shakeri, Ghaffari, Stengel, Thompson, Brown, "Stable numerics for finite-strain elasticity", Int. J. Numer. Methods
/// Eng. (2024).
#pragma once

#include "base/tensor.hpp"

namespace pliant {

/// eps = (H + H^T) / 2.
template <class T>
PLIANT_INLINE Tensor3<T> small_strain(const Tensor3<T>& H) {
  const T e01 = 0.5 * (H(0, 1) + H(1, 0));
  const T e02 = 0.5 * (H(0, 2) + H(2, 0));
  const T e12 = 0.5 * (H(1, 2) + H(2, 1));
  return {{H(0, 0), e01, e02, e01, H(1, 1), e12, e02, e12, H(2, 2)}};
}

/// Green-Lagrange strain E = (F^T F - I) / 2 = (H + H^T + H^T H) / 2.
template <class T>
PLIANT_INLINE Tensor3<T> green_lagrange(const Tensor3<T>& H) {
  const auto entry = [&](int i, int j) -> T {
    return 0.5 * ((H(i, j) + H(j, i)) + (H(0, i) * H(0, j) + H(1, i) * H(1, j) + H(2, i) * H(2, j)));
  };
  const T e01 = entry(0, 1);
  const T e02 = entry(0, 2);
  const T e12 = entry(1, 2);
  return {{entry(0, 0), e01, e02, e01, entry(1, 1), e12, e02, e12, entry(2, 2)}};
}

/// E(H + dH) - E(H) = sym((F + dH/2)^T dH), accurate relative to the change.
template <class T>
PLIANT_INLINE Tensor3<T> green_lagrange_change(const Tensor3<T>& H, const Tensor3<T>& dH) {
  return small_strain(matmul(transpose(add_to_diagonal(H + 0.5 * dH, 1.0)), dH));
}

/// Volume change J - 1 = det F - 1 = tr H + (tr^2 H - tr H^2) / 2 + det H.
template <class T>
PLIANT_INLINE T volume_change(const Tensor3<T>& H) {
  return trace(H) + (second_invariant(H) + det(H));
}

/// det(F + dF) - det F, accurate relative to the change.
template <class T>
PLIANT_INLINE T det_change(const Tensor3<T>& F, const Tensor3<T>& dF) {
  return dot(cofactor(F), dF) + (dot(F, cofactor(dF)) + det(dF));
}

}  // namespace pliant
