#include "energy/constraint/descent.hpp"
#include "energy/constraint/mechanism.hpp"

#include <algorithm>
#include <eigen3/Eigen/Eigenvalues>
#include <eigen3/Eigen/QR>
#include <eigen3/Eigen/SVD>

// The coordinates of the solutions of the joints' equations.

namespace pliant {
namespace {

/// Columns that keep less than this of their length give way to others.
constexpr double least_kept = 0.1;

}  // namespace

// By the normal equations, which lose digits where equations are nearly dependent; there by orthogonal factors.
Mechanism::Matrix Mechanism::preferred_in_null_space() const {
  Matrix result = preferred_;
  const JointFactors squares = G_ref_.factors(Vector::Ones(G_ref_.cols()), G_ref_);
  constexpr int most_corrections = 2;
  for (int i = 0;; ++i) {
    const Matrix rest = G_ref_ * result;
    if (rest.size() == 0 || rest.lpNorm<Eigen::Infinity>() <= joint_tolerance) return result;
    if (i == most_corrections) break;
    result -= G_ref_.transposed_times(squares.solve(rest));
  }
  const Eigen::HouseholderQR<Matrix> qr(G_ref_.dense().transpose());
  result = qr.householderQ().adjoint() * preferred_;
  result.topRows(std::min(G_ref_.rows(), G_ref_.cols())).setZero();
  result.applyOnTheLeft(qr.householderQ());
  return result;
}

// The orthonormal columns nearest to the preferred ones: the polar factor of their part in the null space of G.
void Mechanism::choose_columns() {
  const Eigen::Index n = G_ref_.cols(), num_free = n - std::min(G_ref_.rows(), n);
  const auto are_near_preferred = [&] {
    if (preferred_.cols() != num_free || preferred_.rows() != n || num_free == 0) return false;
    columns_ = preferred_in_null_space();
    const Eigen::SelfAdjointEigenSolver<Matrix> squares(columns_.transpose() * columns_);
    if (squares.eigenvalues()[0] < least_kept * least_kept) return false;
    columns_ *= squares.operatorInverseSqrt();
    return true;
  };
  if (!are_near_preferred()) {
    const Eigen::HouseholderQR<Matrix> qr(G_ref_.dense().transpose());
    columns_ = Matrix(qr.householderQ()).rightCols(num_free);
  }
  if (num_free > 0 && weights_.minCoeff() < 1.0) separate_held_parts();
}

// Else small displacements of held parts would be differences of large unknowns, and lost in their rounding errors.
void Mechanism::separate_held_parts() {
  constexpr double nothing = 1e-14;  // of squares of motions of the size 1
  const Vector are_held = (weights_.array() < 1.0).cast<double>();
  const Matrix of_held = are_held.asDiagonal() * columns_;
  const Eigen::SelfAdjointEigenSolver<Matrix> squares(of_held.transpose() * of_held);
  const auto num_alone = static_cast<Eigen::Index>(
      std::ranges::count_if(squares.eigenvalues(), [](double square) { return square < nothing; }));
  if (preferred_.size() == 0) num_alone_ = num_alone;
  if (num_alone == 0) return;
  Matrix with_held = columns_ * squares.eigenvectors().rightCols(columns_.cols() - num_alone),
         alone = columns_ * squares.eigenvectors().leftCols(num_alone);
  alone = Vector(Vector::Ones(are_held.size()) - are_held).asDiagonal() * alone;
  // The bases of both that are nearest to the preferred columns (orthogonal Procrustes problem).
  const auto align = [](Matrix& basis, const Matrix& preferred) {
    if (basis.cols() == 0) return;
    const Eigen::JacobiSVD<Matrix> svd(basis.transpose() * preferred, Eigen::ComputeFullU | Eigen::ComputeFullV);
    basis *= svd.matrixU() * svd.matrixV().transpose();
  };
  if (preferred_.cols() == columns_.cols() && num_alone == num_alone_) {
    align(with_held, preferred_.leftCols(with_held.cols()));
    align(alone, preferred_.rightCols(num_alone));
  }
  columns_ << with_held, alone;
}

// change = N y + A z, A = D G_ref^T, where G_ref N = 0 and N^T N = I.
std::vector<double> Mechanism::coordinates(const Vector& change) const {
  Vector rest = change;
  if (weights_.minCoeff() < 1.0) rest -= across(G_ref_.factors(weights_, G_ref_).solve(G_ref_ * change));
  const Vector y = columns_.transpose() * rest;
  return {y.begin(), y.end()};
}

std::optional<JointSystem::Matrix> Mechanism::free_motions_near(const Vector& moved) const {
  Vector xi = preferred_ * moved;
  if (!approach(xi)) return std::nullopt;
  Vector g;
  JointDerivative G;
  joints_.configuration(motions(xi), Along::columns, given_, g, G);
  const Eigen::HouseholderQR<Matrix> qr(G.dense().transpose());
  return Matrix(qr.householderQ()).rightCols(preferred_.cols());
}

}  // namespace pliant
