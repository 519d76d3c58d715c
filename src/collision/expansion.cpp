#include "collision/expansion.hpp"

#include <eigen3/Eigen/Eigenvalues>

namespace pliant {

void project_to_positive_semidefinite(Expansion<4>& f) {
  using Matrix = Eigen::Matrix<double, 12, 12>;
  Matrix K;
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) K(row, column) = f.block(row / 3, column / 3)(row % 3, column % 3);
  }
  if (!K.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(K);
  const auto& values = solver.eigenvalues();
  const auto& vectors = solver.eigenvectors();
  // K minus its negative part: the other eigenvalues keep their digits.
  for (int k = 0; k < 12 && values[k] < 0.0; ++k) {  // ascending
    for (int row = 0; row < 12; ++row) {
      for (int column = 0; column < 12; ++column) {
        f.block(row / 3, column / 3)(row % 3, column % 3) -= values[k] * vectors(row, k) * vectors(column, k);
      }
    }
  }
}

}  // namespace pliant
