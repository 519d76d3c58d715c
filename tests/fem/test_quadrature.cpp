#include "fem/quadrature.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace pliant::test_quadrature {
namespace {

double power(double x, int n) {
  return n == 0 ? 1.0 : x * power(x, n - 1);
}

double factorial(int n) {
  return std::tgamma(n + 1.0);
}

/// Largest relative error of the rule over the monomials x^i y^j z^k of total degree n; the exact integral over the
/// simplex is i! j! k! / (n + dim)!.
template <int Dim>
double worst_error(const QuadratureRule<Dim>& rule, int n) {
  double worst = 0.0;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      const int k = n - i - j;
      if ((Dim == 2 && k > 0) || (Dim == 1 && j + k > 0)) continue;
      double sum = 0.0;
      for (int q = 0; q < rule.size(); ++q) {
        const auto& x = rule.points[q];
        sum += rule.weights[q] * power(x[0], i) * power(x[Dim > 1 ? 1 : 0], j) * power(x[Dim - 1], k);
      }
      const double exact = factorial(i) * factorial(j) * factorial(k) / factorial(n + Dim);
      worst = std::max(worst, std::abs(sum / exact - 1.0));
    }
  }
  return worst;
}

class Rules : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Degrees, Rules, ::testing::Range(0, 13));

template <int Dim>
void check_rule(int degree) {
  const auto rule = simplex_rule<Dim>(degree);
  for (int n = 0; n <= degree; ++n) EXPECT_LE(worst_error(rule, n), 2e-14) << "monomials of degree " << n;
  for (int q = 0; q < rule.size(); ++q) {
    EXPECT_GT(rule.weights[q], 0.0);
    double last = 1.0;
    for (const double x : rule.points[q]) {
      EXPECT_GT(x, 0.0);
      last -= x;
    }
    EXPECT_GT(last, 0.0);
  }
}

TEST_P(Rules, IntegrateTheirDegreeFromPointsInside) {
  check_rule<3>(GetParam());
  check_rule<2>(GetParam());
  check_rule<1>(GetParam());
}

TEST(NamedRules, HaveTheirPoints) {
  EXPECT_EQ(simplex_rule<3>(1).size(), 1);
  EXPECT_EQ(simplex_rule<3>(2).size(), 4);
  EXPECT_EQ(simplex_rule<3>(5).size(), 14);
  EXPECT_EQ(simplex_rule<2>(2).size(), 3);
  const auto x = simplex_rule<3>(2).points[1];
  EXPECT_NEAR(*std::max_element(x.begin(), x.end()), 0.58541020, 5e-9);
  EXPECT_NEAR(*std::min_element(x.begin(), x.end()), 0.13819660, 5e-9);
}

}  // namespace
}  // namespace pliant::test_quadrature
