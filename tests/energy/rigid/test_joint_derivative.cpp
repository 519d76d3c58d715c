// Derivatives of joints' equations and the systems with them, against dense matrices.
#include "energy/rigid/joint_derivative.hpp"

#include <cmath>
#include <eigen3/Eigen/LU>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test_joint_derivative {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Which bodies each joint connects, -1: the ground, in how many equations.
struct Case {
  std::string name;
  std::size_t num_bodies, num_equations;
  std::vector<std::array<int, 2>> joints;
  int bandwidth;
};

class JointDerivatives : public ::testing::TestWithParam<Case> {
 protected:
  JointDerivatives() {
    const Case& c = GetParam();
    for (std::size_t p = 0; p < c.num_bodies; ++p) first_.push_back(first_.back() + (p % 3 == 2 ? 4 : 6));
    for (const auto& joint : c.joints) bodies_.insert(bodies_.end(), c.num_equations, joint);
    pattern_ = std::make_shared<JointPattern>(bodies_, first_);
  }
  /// Derivatives that are large in the unknowns of one body.
  JointDerivative rough(double seed) const {
    JointDerivative G(pattern_);
    for (std::size_t row = 0; row < bodies_.size(); ++row) {
      for (std::size_t side = 0; side < 2; ++side) {
        double k = 0.0;  // number of the entry
        for (double& value : G.entries(row, side)) {
          k += 1.0;
          value = std::sin(seed + 1.37 * (1.0 + static_cast<double>(row)) * (k + 1.6 * static_cast<double>(side)) * k);
        }
      }
    }
    return G;
  }

  std::vector<std::size_t> first_{0};
  std::vector<std::array<int, 2>> bodies_;
  std::shared_ptr<const JointPattern> pattern_;
};

TEST_P(JointDerivatives, HaveNarrowBands) {
  EXPECT_LE(pattern_->bandwidth(), GetParam().bandwidth);
}

TEST_P(JointDerivatives, MultiplyLikeDenseMatrices) {
  const JointDerivative G = rough(1.0);
  const Matrix dense = G.dense();
  EXPECT_EQ(dense.rows(), static_cast<Eigen::Index>(bodies_.size()));
  EXPECT_EQ(dense.cols(), static_cast<Eigen::Index>(first_.back()));
  for (std::size_t row = 0; row < bodies_.size(); ++row) {
    const auto i = static_cast<Eigen::Index>(row);
    EXPECT_NEAR(G.norm_of_row(row), dense.row(i).norm(), 1e-14);
    for (std::size_t side = 0; side < 2; ++side) {
      if (bodies_[row][side] < 0) continue;
      const auto first = static_cast<Eigen::Index>(first_[static_cast<std::size_t>(bodies_[row][side])]);
      EXPECT_EQ(dense(i, first), G.entries(row, side)[0]);
    }
  }
  const Matrix z = Matrix::Random(dense.rows(), 3);
  EXPECT_LT((G.transposed_times(z) - dense.transpose() * z).norm(), 1e-13);
}

TEST_P(JointDerivatives, SolveLikeDenseMatrices) {
  const JointDerivative G = rough(1.0), H = rough(1.1);
  Vector D = Vector::Ones(G.cols());
  for (Eigen::Index k = 0; k < D.size(); k += 4) D[k] = 1e-3;
  const Matrix whole = G.dense() * D.asDiagonal() * H.dense().transpose();
  const JointFactors factors = G.factors(D, H);
  const Vector b = Vector::LinSpaced(G.rows(), -1.0, 2.0);
  const double tolerance = 1e-15 * whole.norm() * whole.inverse().norm();
  EXPECT_LT((whole * factors.solve(b) - b).norm(), tolerance * b.norm());
  EXPECT_LT((whole.transpose() * factors.solve_transposed(b) - b).norm(), tolerance * b.norm());
  const Vector change = G.smallest_change(b, D);
  EXPECT_LT((G * change - b).norm(), 1e-9 * b.norm());
  // It is D G^T of something.
  const Matrix across = D.asDiagonal() * G.dense().transpose();
  EXPECT_LT((across * across.fullPivLu().solve(change) - change).norm(), 1e-9 * change.norm());
}

TEST_P(JointDerivatives, HaveNoSolutionOfDependentEquations) {
  JointDerivative G = rough(1.0);
  G.scale_row(0, 0.0);
  const Vector x = G.factors(Vector::Ones(G.cols()), G).solve(Vector(Vector::Ones(G.rows())));
  EXPECT_FALSE(x.allFinite());
}

INSTANTIATE_TEST_SUITE_P(
    Mechanisms, JointDerivatives,
    ::testing::Values(Case{"Chain", 8, 3, {{-1, 0}, {0, 1}, {1, 2}, {2, 3}, {4, 3}, {4, 5}, {5, 6}, {7, 6}}, 5},
                      Case{"Star", 5, 2, {{-1, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}}, 9},
                      Case{"Loop", 4, 4, {{-1, 0}, {0, 1}, {1, 2}, {2, 3}, {3, -1}}, 7},
                      Case{"Apart", 3, 3, {{2, -1}, {0, 1}}, 4}, Case{"Single", 1, 1, {{-1, 0}}, 0}),
    [](const auto& of) { return of.param.name; });

}  // namespace
}  // namespace pliant::test_joint_derivative
