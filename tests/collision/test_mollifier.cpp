#include "collision/mollifier.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>

namespace pliant::test_mollifier {
namespace {

using namespace testing_collision;

/// An edge of length about 1 along x, and another at the given angle above it.
Points<4> edges_at(double angle, RandomPoints& random) {
  Points<4> x{{{0, 0, 0}, {1, 0, 0}, {0.1, -0.2, 0.1}, {0.1 + std::cos(angle), -0.2 + std::sin(angle), 0.1}}};
  for (auto& p : x) p = p + random.point(1e-4);
  return x;
}

TEST(Mollifier, DerivativesMatchDifferences) {
  constexpr double threshold = 1e-3;
  const auto f = [&](const Points<4>& x) { return edge_edge_mollifier(x, threshold); };
  RandomPoints random(1);
  int compared = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto x = edges_at(random.number(0.004, 0.03), random);
    if (f(x).value > 0.999 || f(x).value < 1e-7) continue;
    const DerivativeErrors errors = compare_with_differences<4>(f, x, 1e-7);
    EXPECT_LT(errors.gradient, 1e-5) << trial;
    EXPECT_LT(errors.hessian, 1e-5) << trial;
    ++compared;
  }
  EXPECT_GT(compared, 2000);
}

/// m = 0 with its derivatives where the edges are parallel, 1 from the threshold on, and C2 across both.
TEST(Mollifier, HasTwoContinuousDerivatives) {
  constexpr double threshold = 1e-2;  // sin^2 of the angle
  const auto at = [&](double sine) {
    const double cosine = std::sqrt(1.0 - sine * sine);
    return edge_edge_mollifier(Points<4>{{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {cosine, sine, 1}}}, threshold);
  };
  const Expansion<4> parallel = at(0.0);
  EXPECT_EQ(parallel.value, 0.0);
  EXPECT_EQ(size_of_gradient(parallel), 0.0);
  EXPECT_EQ(size_of_hessian(parallel), 0.0);
  EXPECT_LT(size_of_hessian(at(1e-4)), 1e-6);
  const Expansion<4> below = at(0.1 * (1 - 1e-7)), above = at(0.1 * (1 + 1e-7));
  EXPECT_NEAR(below.value, 1.0, 1e-12);
  EXPECT_EQ(above.value, 1.0);
  const double largest = size_of_hessian(at(0.06));
  EXPECT_GT(largest, 10.0);
  EXPECT_LT(size_of_hessian(below), 1e-4 * largest);
  EXPECT_EQ(size_of_hessian(above), 0.0);
}

TEST(Mollifier, ValueAloneIsTheSame) {
  RandomPoints random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto x = edges_at(random.number(0.0, 0.05), random);
    EXPECT_NEAR(edge_edge_mollifier_value(x, 1e-3), edge_edge_mollifier(x, 1e-3).value, 1e-14);
  }
}

TEST(Mollifier, ThresholdIsAnAngleWhereEdgesKeepTheirLengths) {
  const double angle = std::asin(std::sqrt(1e-3));  // 1.8 degrees
  const auto edges = [](double a) {
    return Points<4>{{{0, 0, 0}, {2, 0, 0}, {0, 0, 1}, {3 * std::cos(a), 3 * std::sin(a), 1}}};
  };
  const double threshold = mollifier_threshold(edges(1.0));
  EXPECT_EQ(edge_edge_mollifier_value(edges(1.01 * angle), threshold), 1.0);
  EXPECT_LT(edge_edge_mollifier_value(edges(0.9 * angle), threshold), 1.0);
}

}  // namespace
}  // namespace pliant::test_mollifier
