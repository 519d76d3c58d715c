/// Cholesky's factorization of small dense matrices.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace pliant {

template <std::size_t N>
using SmallMatrix = std::array<std::array<double, N>, N>;

/// M = L L^T of the leading n x n block of a symmetric positive definite M, in place: the lower triangle becomes L.
template <std::size_t N>
void factorize_by_cholesky(SmallMatrix<N>& M, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t k = 0; k < j; ++k) M[j][j] -= M[j][k] * M[j][k];
    M[j][j] = std::sqrt(M[j][j]);
    for (std::size_t i = j + 1; i < n; ++i) {
      for (std::size_t k = 0; k < j; ++k) M[i][j] -= M[i][k] * M[j][k];
      M[i][j] /= M[j][j];
    }
  }
}

/// x = (L L^T)^-1 x, with as many entries as L has rows.
template <std::size_t N>
void solve_by_cholesky(const SmallMatrix<N>& L, std::span<double> x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
  for (std::size_t i = x.size(); i-- > 0;) {
    for (std::size_t k = i + 1; k < x.size(); ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
}

}  // namespace pliant
