// How exactly linear systems are solved.
#include "solver/forcing.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_forcing {
namespace {

/// Newton's method where the linear model leaves the k-th part of the residual out, and the linear solver what it was
/// allowed to; the residuals along the way.
std::vector<double> iterate(Forcing& forcing, const std::vector<double>& left_out, double residual, double target) {
  std::vector<double> residuals{residual};
  for (std::size_t k = 0; residual > target && k < left_out.size(); ++k) {
    const double tolerance = forcing.tolerance(static_cast<int>(k), residual, target);
    residual *= tolerance + left_out[k];
    forcing.observe(residual);
    residuals.push_back(residual);
  }
  return residuals;
}

TEST(Forcing, LearnsWhatTheLinearModelLeavesOut) {
  Forcing forcing;
  const std::vector<double> left_out{0.02, 1e-4, 1e-9};
  std::vector<double> residuals;
  for (int stage = 0; stage < 10; ++stage) residuals = iterate(forcing, left_out, 1.0, 1e-10);
  ASSERT_EQ(residuals.size(), 4u);
  EXPECT_LT(residuals[1], 1.5 * left_out[0]);
  EXPECT_LT(residuals[2], 1.5 * left_out[1] * residuals[1]);
  // And no better than that is worth.
  EXPECT_GT(forcing.tolerance(0, 1.0, 1e-10), 0.1 * left_out[0]);
  EXPECT_GT(forcing.tolerance(1, 1.0, 1e-10), 0.1 * left_out[1]);
}

TEST(Forcing, NeverSolvesFurtherThanTheStageIsToReach) {
  Forcing forcing;
  for (int stage = 0; stage < 10; ++stage) iterate(forcing, {1e-12, 1e-12, 1e-12}, 1.0, 1e-6);
  const double tolerance = forcing.tolerance(0, 1.0, 1e-6);
  EXPECT_GE(tolerance, 1e-7);
  EXPECT_LT(tolerance, 1e-6);  // so that one iteration is enough
  EXPECT_LE(forcing.tolerance(1, 1e-6, 1e-6), 0.1);
}

TEST(Forcing, FollowsAHarderStageAndForgets) {
  Forcing forcing;
  const double fresh = forcing.tolerance(0, 1.0, 1e-12);
  for (int stage = 0; stage < 10; ++stage) iterate(forcing, {1e-8}, 1.0, 1e-12);
  EXPECT_LT(forcing.tolerance(0, 1.0, 1e-12), 1e-8);
  iterate(forcing, {0.5}, 1.0, 1e-12);
  EXPECT_GT(forcing.tolerance(0, 1.0, 1e-12), 1e-3);
  forcing.forget();
  EXPECT_EQ(forcing.tolerance(0, 1.0, 1e-12), fresh);
}

}  // namespace
}  // namespace pliant::test_forcing
