#include "collision/potential.hpp"

#include <algorithm>
#include <eigen3/Eigen/Eigenvalues>

namespace pliant {
namespace {

/// I - n n^T - sum t_k t_k^T: the directions along both features.
template <int N>
Tensor3<double> along_features(const Separation<N>& at) {
  const auto& n = at.normal;
  const auto& [t, s] = at.tangents;
  return make_tensor([&](int p, int q) { return (p == q ? 1.0 : 0.0) - n[p] * n[q] - t[p] * t[q] - s[p] * s[q]; });
}

/// Orthonormal vectors of N weights that span w and w_k; w_k = sum_l coefficients(k, l) basis_l, w = size basis_0.
template <int N>
struct WeightBasis {
  std::array<std::array<double, N>, 3> vectors{};
  std::array<std::array<double, 3>, 2> coefficients{};
  double size = 0.0;
};

template <int N>
WeightBasis<N> weight_basis(const Separation<N>& at) {
  const auto inner = [](const auto& a, const auto& b) {
    double total = 0.0;
    for (int i = 0; i < N; ++i) total += a[i] * b[i];
    return total;
  };
  WeightBasis<N> basis;
  basis.size = std::sqrt(inner(at.weights, at.weights));
  for (int i = 0; i < N; ++i) basis.vectors[0][i] = at.weights[i] / basis.size;
  for (int k = 0; k < at.num_slopes; ++k) {
    auto rest = at.slopes[k];
    for (int l = 0; l <= k; ++l) {
      const double along = inner(rest, basis.vectors[l]);
      basis.coefficients[k][l] = along;
      for (int i = 0; i < N; ++i) rest[i] -= along * basis.vectors[l][i];
    }
    const double size = std::sqrt(inner(rest, rest));
    basis.coefficients[k][k + 1] = size;
    for (int i = 0; i < N; ++i) basis.vectors[k + 1][i] = rest[i] / size;
  }
  return basis;
}

/// The positive part of a symmetric matrix; `true` where it had a negative one.
template <int Rows>
bool clamp(Eigen::Matrix<double, Rows, Rows>& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Rows, Rows>> solver(M);
  const auto& values = solver.eigenvalues();
  const bool has_negative = values[0] < 0.0;
  for (int k = 0; k < Rows && values[k] < 0.0; ++k) {
    M -= values[k] * solver.eigenvectors().col(k) * solver.eigenvectors().col(k).transpose();
  }
  return has_negative;
}

/// In the basis (basis_l n for l = 0..K, basis_0 t_k for k < K) the matrix M, its projection, and back.
template <int N, int K>
void project(const Separation<N>& at, double pressure, double stiffness, PotentialForm<N>& form) {
  const WeightBasis<N> basis = weight_basis(at);
  Eigen::Matrix<double, 1 + 2 * K, 1 + 2 * K> M;
  M.setZero();
  M(0, 0) = stiffness * basis.size * basis.size;
  for (int k = 0; k < K; ++k) {
    const auto& c = basis.coefficients[k];
    for (int l = 0; l <= K; ++l) {
      for (int m = 0; m <= K; ++m) M(l, m) += pressure * at.distance * c[l] * c[m];
      M(l, 1 + K + k) += pressure * basis.size * c[l];
      M(1 + K + k, l) += pressure * basis.size * c[l];
    }
  }
  if (!M.allFinite() || !clamp(M)) return;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      double total = 0.0;
      for (int l = 0; l <= K; ++l) {
        for (int m = 0; m <= K; ++m) total += basis.vectors[l][i] * M(l, m) * basis.vectors[m][j];
      }
      form.normal[N * i + j] = total;
    }
    for (int k = 0; k < K; ++k) {
      form.mixed[k][i] = 0.0;
      for (int l = 0; l <= K; ++l) form.mixed[k][i] += basis.vectors[l][i] * M(l, 1 + K + k) / basis.size;
    }
  }
  for (int k = 0; k < K; ++k) {
    for (int l = 0; l < K; ++l) {
      const double part = M(1 + K + k, 1 + K + l) / (basis.size * basis.size);
      form.tangential =
          form.tangential + make_tensor([&](int p, int q) { return part * at.tangents[k][p] * at.tangents[l][q]; });
    }
  }
}

}  // namespace

template <int N>
PotentialForm<N> exact_form(const Separation<N>& at, double pressure, double stiffness) {
  PotentialForm<N> form;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      form.normal[N * i + j] =
          stiffness * at.weights[i] * at.weights[j] +
          pressure * at.distance * (at.slopes[0][i] * at.slopes[0][j] + at.slopes[1][i] * at.slopes[1][j]);
    }
    for (int k = 0; k < 2; ++k) form.mixed[k][i] = pressure * at.slopes[k][i];
  }
  if (at.num_slopes < 2) form.tangential = (-pressure / at.distance) * along_features(at);
  return form;
}

template <int N>
PotentialForm<N> semidefinite_form(const Separation<N>& at, double pressure, double stiffness) {
  PotentialForm<N> form = exact_form<N>(at, pressure, stiffness);
  // The part along both features is orthogonal to all others: it is projected by itself.
  if (pressure > 0.0) form.tangential = {};
  switch (at.num_slopes) {
    case 0:
      if (stiffness < 0.0) form.normal.fill(0.0);
      break;
    case 1:
      project<N, 1>(at, pressure, stiffness, form);
      break;
    default:
      project<N, 2>(at, pressure, stiffness, form);
  }
  return form;
}

Expansion<4> product(const Expansion<4>& m, const Expansion<4>& U) {
  Expansion<4> f;
  f.value = m.value * U.value;
  for (int i = 0; i < 4; ++i) {
    f.gradient[i] = m.value * U.gradient[i] + U.value * m.gradient[i];
    for (int j = 0; j < 4; ++j) {
      f.block(i, j) = make_tensor([&](int p, int q) {
        return m.value * U.block(i, j)(p, q) + U.value * m.block(i, j)(p, q) + m.gradient[i][p] * U.gradient[j][q] +
               U.gradient[i][p] * m.gradient[j][q];
      });
    }
  }
  return f;
}

template PotentialForm<2> exact_form(const Separation<2>&, double, double);
template PotentialForm<3> exact_form(const Separation<3>&, double, double);
template PotentialForm<4> exact_form(const Separation<4>&, double, double);
template PotentialForm<5> exact_form(const Separation<5>&, double, double);
template PotentialForm<6> exact_form(const Separation<6>&, double, double);
template PotentialForm<2> semidefinite_form(const Separation<2>&, double, double);
template PotentialForm<3> semidefinite_form(const Separation<3>&, double, double);
template PotentialForm<4> semidefinite_form(const Separation<4>&, double, double);
template PotentialForm<5> semidefinite_form(const Separation<5>&, double, double);
template PotentialForm<6> semidefinite_form(const Separation<6>&, double, double);

}  // namespace pliant
