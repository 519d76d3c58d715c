#include "base/limits.hpp"
#include "base/simd.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_simd {
namespace {

/// |value - reference| in units of the last place of the reference.
double ulps(double value, long double reference) {
  const double rounded = std::abs(static_cast<double>(reference));
  const long double ulp = std::nextafter(rounded, infinity) - rounded;
  return static_cast<double>(std::abs(static_cast<long double>(value) - reference) / ulp);
}

/// x - ln(1 + x) by its power series where the difference would cancel.
long double x_minus_log1p_reference(long double x) {
  if (std::abs(x) > 0.25L) return x - std::log1p(x);
  long double sum = 0;
  long double power = -x;
  for (int n = 2; n < 60; ++n) {
    power *= -x;
    sum += power / n;
  }
  return sum;
}

/// f(x) for |x| spaced by the logarithm from 1e-300 to 1 on both sides of 0, and on to 1e300 on the right.
template <class F>
void sweep(const F& f) {
  for (int n = -300 * 512; n < 300 * 512; ++n) {
    const double x = std::pow(10.0, n / 512.0) * (1.0 + 1e-3 * std::sin(n));
    f(x);
    if (x < 1.0) f(-x);
  }
  for (int n = -9999; n < 10000; ++n) f(n * 1e-4);  // the series and its ends, densely
}

TEST(Log1p, IsExactToTwoUlp) {
  double worst = 0;
  sweep([&](double x) { worst = std::max(worst, ulps(log1p(x), std::log1p(static_cast<long double>(x)))); });
  EXPECT_LE(worst, 2.0);
}

TEST(Log1p, DifferenceFromXIsExactToSixUlp) {
  double worst = 0;
  sweep([&](double x) {
    if (std::abs(x) < 1e-150) return;  // x^2 / 2 is subnormal
    worst = std::max(worst, ulps(x_minus_log1p(x), x_minus_log1p_reference(x)));
  });
  EXPECT_LE(worst, 6.0);  // the most just outside the series, from the rounding of libm's logarithm
}

TEST(Log1p, EndsOfTheDomainAsInLibm) {
  EXPECT_EQ(log1p(0.0), 0.0);
  EXPECT_TRUE(std::signbit(log1p(-0.0)));
  EXPECT_EQ(log1p(std::numeric_limits<double>::denorm_min()), std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(log1p(-1.0), -infinity);
  EXPECT_TRUE(std::isnan(log1p(-1.5)));
  EXPECT_EQ(log1p(infinity), infinity);
  EXPECT_TRUE(std::isnan(log1p(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(x_minus_log1p(-1.0), infinity);
  EXPECT_TRUE(std::isnan(x_minus_log1p(-1.5)));
}

TEST(Log1p, PackEqualsScalarLaneByLane) {
  std::array<double, 8> values{1e-9, -0.2, 0.6, -0.39, 1e-3, -1e-15, 0.1, 0.0};
  for (const bool all_in_series : {true, false}) {
    if (!all_in_series) values[pack_size - 1] = -2.0;
    const Pack x([&](auto i) { return values[i]; });
    const Pack log = log1p(x);
    const Pack gap = x_minus_log1p(x);
    for (std::size_t i = 0; i < Pack::size(); ++i) {
      if (values[i] < -1.0) {
        EXPECT_TRUE(std::isnan(static_cast<double>(log[i])));
        continue;
      }
      // The same operations, but the compiler may fuse other pairs of them.
      EXPECT_LE(ulps(log[i], log1p(values[i])), 1.0);
      EXPECT_LE(ulps(gap[i], x_minus_log1p(values[i])), 2.0);
    }
  }
}

TEST(Log1p, SeriesOfOtherTypesReachesTheirPrecision) {
  for (const long double x : {1e-9L, 0.3L, -0.5L, 2.0L, -1e-20L}) {
    EXPECT_LE(std::abs(log1p(x) - std::log1p(x)),
              8 * std::numeric_limits<long double>::epsilon() * std::abs(std::log1p(x)));
  }
}

TEST(Pack, SelectAndSum) {
  const Pack x([](auto i) { return static_cast<double>(i); });
  const Pack y = select(x > 0.5, x, Pack(-1.0));
  EXPECT_EQ(y[0], -1.0);
  EXPECT_EQ(y[1], 1.0);
  EXPECT_EQ(sum(x), 0.5 * pack_size * (pack_size - 1));
  EXPECT_EQ(select(true, 1.0, 2.0), 1.0);
  EXPECT_TRUE(any_of(x > 0.5));
  EXPECT_FALSE(all_of(x > 0.5));
}

}  // namespace
}  // namespace pliant::test_simd
