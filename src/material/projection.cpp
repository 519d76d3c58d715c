#include "material/projection.hpp"

#include <algorithm>
#include <eigen3/Eigen/Eigenvalues>

namespace pliant {
namespace {

/// Raises the eigenvalues of a symmetric n x n matrix to `floor`.
template <int n>
void clamp_eigenvalues(double* entries, double floor) {
  using Matrix = Eigen::Matrix<double, n, n>;
  Eigen::Map<Matrix> matrix(entries);
  if (!matrix.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(matrix);
  const auto& values = solver.eigenvalues();
  const auto& vectors = solver.eigenvectors();
  // A + sum over the low eigenvalues of (floor - value) v v^T: the other eigenvalues remain exact.
  for (int k = 0; k < n && values[k] < floor; ++k) {  // ascending
    const Matrix correction = (floor - values[k]) * vectors.col(k) * vectors.col(k).transpose();
    matrix += correction;
  }
}

template <int n>
void clamp_eigenvalues(std::array<Pack, n * n>& A, double floor) {
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    std::array<double, n * n> single;
    std::ranges::transform(A, single.begin(), [lane](const Pack& a) { return static_cast<double>(a[lane]); });
    clamp_eigenvalues<n>(single.data(), floor);
    for (std::size_t k = 0; k < single.size(); ++k) A[k][lane] = single[k];
  }
}

}  // namespace

void project_to_positive_semidefinite(Tangent<double>& A, double floor) {
  clamp_eigenvalues<9>(A.data(), floor);
}

void project_to_positive_semidefinite(Tangent<Pack>& A, double floor) {
  clamp_eigenvalues<9>(A, floor);
}

void project_to_positive_semidefinite(std::array<Pack, 100>& M) {
  clamp_eigenvalues<10>(M, 0.0);
}

void project_to_positive_semidefinite(Tensor3<Pack>& S) {
  clamp_eigenvalues<3>(S.a, 0.0);
}

}  // namespace pliant
