// Least squares: minima, bounds and what is not determined, of problems whose answers are known.
#include "base/limits.hpp"
#include "study/least_squares.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace pliant::test_least_squares {
namespace {

LeastSquaresProblem unbounded(std::size_t n, std::size_t p) {
  return {n, std::vector<double>(p, -infinity), std::vector<double>(p, infinity), {}};
}

/// y_i = a + b t_i with noise, t = 0, 1, ..., and what the normal equations give.
struct Line {
  std::vector<double> y;
  double a, b, sum, variance_b;

  Line() : a(0.0), b(0.0), sum(0.0), variance_b(0.0) {
    std::mt19937 engine(3);
    std::normal_distribution<double> noise(0.0, 0.1);
    constexpr int n = 12;
    double t1 = 0.0, t2 = 0.0, y1 = 0.0, ty = 0.0;
    for (int i = 0; i < n; ++i) {
      y.push_back(2.0 - 0.7 * i + noise(engine));
      t1 += i;
      t2 += 1.0 * i * i;
      y1 += y.back();
      ty += i * y.back();
    }
    const double det = n * t2 - t1 * t1;
    a = (t2 * y1 - t1 * ty) / det;
    b = (n * ty - t1 * y1) / det;
    for (int i = 0; i < n; ++i) sum += std::pow(a + b * i - y[static_cast<std::size_t>(i)], 2);
    variance_b = sum / (n - 2) * n / det;
  }

  /// With `twins` > 0 that many more parameters of which only the sum with b counts.
  LeastSquaresProblem problem(std::size_t twins = 0) const {
    LeastSquaresProblem result = unbounded(y.size(), 2 + twins);
    result.evaluate = [this, twins](std::span<const double> x, std::span<double> r, std::span<double> J) {
      const std::size_t p = 2 + twins;
      for (std::size_t i = 0; i < y.size(); ++i) {
        const auto t = static_cast<double>(i);
        r[i] = x[0] + std::accumulate(x.begin() + 1, x.end(), 0.0) * t - y[i];
        J[p * i] = 1.0;
        for (std::size_t j = 1; j < p; ++j) J[p * i + j] = t;
      }
    };
    return result;
  }
};

TEST(LeastSquares, LinearParametersLandOnTheSolutionOfTheNormalEquations) {
  const Line line;
  const LeastSquaresProblem problem = line.problem();
  for (const double start : {0.0, 1e4}) {
    const Minimum found = minimise(problem, std::vector<double>{start, -start});
    EXPECT_TRUE(found.is_converged) << found.reason;
    EXPECT_NEAR(found.x[0], line.a, 1e-10);
    EXPECT_NEAR(found.x[1], line.b, 1e-10);
    EXPECT_NEAR(found.sum, line.sum, 1e-12);
    const Determination known = determination(problem, found, std::vector<double>{1.0, 1.0});
    EXPECT_NEAR(known.covariance[3] / line.variance_b, 1.0, 1e-9);
    EXPECT_TRUE(known.is_determined[0] && known.is_determined[1]);
  }
}

TEST(LeastSquares, FindsTheEndOfRosenbrocksValley) {
  LeastSquaresProblem problem = unbounded(2, 2);
  problem.evaluate = [](std::span<const double> x, std::span<double> r, std::span<double> J) {
    r[0] = 10.0 * (x[1] - x[0] * x[0]);
    r[1] = 1.0 - x[0];
    J[0] = -20.0 * x[0];
    J[1] = 10.0;
    J[2] = -1.0;
    J[3] = 0.0;
  };
  const Minimum found = minimise(problem, std::vector<double>{-1.2, 1.0});
  EXPECT_TRUE(found.is_converged) << found.reason;
  EXPECT_NEAR(found.x[0], 1.0, 1e-10);
  EXPECT_NEAR(found.x[1], 1.0, 1e-10);
}

TEST(LeastSquares, ABoundHoldsItsParameterAndIsReported) {
  const Line line;
  LeastSquaresProblem problem = line.problem();
  problem.lower[1] = -0.5;  // the slope is -0.7
  const Minimum found = minimise(problem, std::vector<double>{0.0, 0.5});
  EXPECT_TRUE(found.is_converged) << found.reason;
  EXPECT_EQ(found.x[1], -0.5);
  double mean = 0.0;
  for (std::size_t i = 0; i < line.y.size(); ++i) mean += (line.y[i] + 0.5 * static_cast<double>(i)) / 12.0;
  EXPECT_NEAR(found.x[0], mean, 1e-10);
  const Determination known = determination(problem, found, std::vector<double>{1.0, 1.0});
  EXPECT_EQ(known.is_at_bound, (std::vector<bool>{false, true}));
  EXPECT_EQ(known.covariance[3], 0.0);
  EXPECT_GT(known.covariance[0], 0.0);
}

TEST(LeastSquares, ASumAloneIsNotDetermined) {
  const Line line;
  const LeastSquaresProblem problem = line.problem(1);
  const Minimum found = minimise(problem, std::vector<double>{0.0, 1.0, 0.3});
  EXPECT_TRUE(found.is_converged) << found.reason;
  EXPECT_NEAR(found.x[1] + found.x[2], line.b, 1e-9);
  const Determination known = determination(problem, found, std::vector<double>{1.0, 1.0, 1.0});
  EXPECT_EQ(known.is_determined, (std::vector<bool>{true, false, false}));
  EXPECT_LT(known.singular_values[2], 1e-12 * known.singular_values[0]);
  EXPECT_NEAR(std::abs(known.modes[2][1]), std::sqrt(0.5), 1e-9);
  EXPECT_EQ(known.covariance[4], infinity);
  EXPECT_TRUE(std::isfinite(known.covariance[0]));
}

TEST(LeastSquares, StaysWhereTheResidualExists) {
  // A step of Gauss and Newton from 3 would end below 0, where the logarithm is not.
  LeastSquaresProblem problem = unbounded(2, 1);
  problem.evaluate = [](std::span<const double> x, std::span<double> r, std::span<double> J) {
    r[0] = x[0] > 0.0 ? std::log(x[0]) + 3.0 : nan;
    r[1] = 0.0;
    J[0] = x[0] > 0.0 ? 1.0 / x[0] : nan;
    J[1] = 0.0;
  };
  const Minimum found = minimise(problem, std::vector<double>{3.0});
  EXPECT_TRUE(found.is_converged) << found.reason;
  EXPECT_NEAR(found.x[0], std::exp(-3.0), 1e-9);
  EXPECT_FALSE(minimise(problem, std::vector<double>{-1.0}).is_converged);
}

TEST(Halton, FillsTheSquareEvenly) {
  std::array<int, 16> counts{};
  for (int n = 1; n <= 288; ++n) {
    const auto point = halton_point(n, 2);
    counts[static_cast<std::size_t>(4 * std::floor(4 * point[0]) + std::floor(4 * point[1]))]++;
  }
  for (const int count : counts) EXPECT_NEAR(count, 18, 2);
  EXPECT_EQ(halton_point(1, 3), (std::vector<double>{1.0 / 2, 1.0 / 3, 1.0 / 5}));
}

}  // namespace
}  // namespace pliant::test_least_squares
