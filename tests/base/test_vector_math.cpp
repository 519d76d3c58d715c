#include "base/vector_math.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_vector_math {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// x from 1e-300 to `most` on both sides of 0, spaced by the logarithm, and densely between.
template <class F>
void sweep(double most, const F& f) {
  for (int n = -300 * 16; std::pow(10.0, n / 16.0) < most; ++n) {
    f(std::pow(10.0, n / 16.0));
    f(-std::pow(10.0, n / 16.0));
  }
  for (int n = -1000; n <= 1000; ++n) f(most * n * 1e-3);
}

/// Of the pack x, x, ..., x in which one lane differs.
template <class F>
double in_a_pack(const F& f, double x) {
  const Pack result = f(Pack([&](auto lane) { return lane == 1 ? x : 0.5; }));
  return result[1];
}

TEST(VectorMath, PackIsNearTheScalar) {
  double worst = 0;
  sweep(300.0, [&](double x) {
    const double e = std::exp(x), m = std::expm1(x), r = std::sqrt(std::abs(x));
    worst = std::max(worst, std::abs(in_a_pack([](const Pack& p) { return exp(p); }, x) - e) / e);
    if (m != 0.0)
      worst = std::max(worst, std::abs(in_a_pack([](const Pack& p) { return expm1(p); }, x) - m) / std::abs(m));
    EXPECT_EQ(in_a_pack([](const Pack& p) { return sqrt(p); }, std::abs(x)), r);
  });
  EXPECT_LE(worst, 4 * epsilon);  // libmvec promises 4 ulp
}

/// (exp x - 1 - ... )/x^k by the power series where it would cancel.
long double phi_reference(int k, long double x) {
  if (std::abs(x) > 2.0L) return k == 1 ? std::expm1(x) / x : (std::expm1(x) - x) / (x * x);
  long double sum = 0, term = k == 1 ? 1.0L : 0.5L;
  for (int n = k + 1; n < 60; ++n) {
    sum += term;
    term *= x / n;
  }
  return sum;
}

TEST(VectorMath, QuotientsOfExponentialsKeepTheirDigits) {
  EXPECT_EQ(phi1(0.0), 1.0);
  EXPECT_EQ(phi2(0.0), 0.5);
  double scalar = 0, pack = 0;
  sweep(50.0, [&](double x) {
    const auto error = [](double value, long double reference) {
      return static_cast<double>(std::abs((value - reference) / reference));
    };
    scalar = std::max({scalar, error(phi1(x), phi_reference(1, x)), error(phi2(x), phi_reference(2, x))});
    pack = std::max({pack, error(in_a_pack([](const Pack& p) { return phi1(p); }, x), phi_reference(1, x)),
                     error(in_a_pack([](const Pack& p) { return phi2(p); }, x), phi_reference(2, x))});
  });
  EXPECT_LE(scalar, 4 * epsilon);
  EXPECT_LE(pack, 12 * epsilon);  // just beyond 1 the difference takes a bit and a half of expm1's 4 ulp
}

}  // namespace
}  // namespace pliant::test_vector_math
