#include "material/projection.hpp"

#include <algorithm>
#include <eigen3/Eigen/Eigenvalues>

namespace pliant {

void project_to_positive_semidefinite(Tangent<double>& A, double floor) {
  using Matrix = Eigen::Matrix<double, 9, 9>;
  Eigen::Map<Matrix> matrix(A.data());
  if (!matrix.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(matrix);
  const auto& values = solver.eigenvalues();
  const auto& vectors = solver.eigenvectors();
  // A + sum over the low eigenvalues of (floor - value) v v^T: the others keep their digits.
  for (int n = 0; n < 9 && values[n] < floor; ++n) {  // ascending
    const Matrix correction = (floor - values[n]) * vectors.col(n) * vectors.col(n).transpose();
    matrix += correction;
  }
}

void project_to_positive_semidefinite(Tangent<Pack>& A, double floor) {
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    Tangent<double> single;
    std::ranges::transform(A, single.begin(), [lane](const Pack& a) { return static_cast<double>(a[lane]); });
    project_to_positive_semidefinite(single, floor);
    for (std::size_t n = 0; n < single.size(); ++n) A[n][lane] = single[n];
  }
}

}  // namespace pliant
