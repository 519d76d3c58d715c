// Roots are those of the formula itself, and what they say of stability holds all over the left half plane.
#include "time/formula.hpp"
#include "time/linear_stability.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant::test_linear_stability {
namespace {

using test::all_methods;
using Complex = std::complex<double>;

double largest_modulus(const Method& m, Complex z) {
  double largest = 0.0;
  for (const Complex& zeta : amplification(m, z)) largest = std::max(largest, std::abs(zeta));
  return largest;
}

TEST(Amplification, IsWhatAStepDoesToAMode) {
  for (const auto& [what, m] : all_methods()) {
    for (const Complex z : {Complex(-0.3, 0.7), Complex(0.0, 2.0), Complex(-20.0, 5.0)}) {
      const auto zeta = amplification(m, z);
      ASSERT_EQ(zeta.size(), m.alpha.size());
      for (const Complex& root : zeta) {
        std::vector<Complex> past, increments;
        for (int r = 0; r < m.num_steps; ++r) past.push_back(std::pow(root, m.num_steps - 1 - r));
        const Complex end = test::linear_step(m, z, past, increments);
        EXPECT_LT(std::abs(end - std::pow(root, m.num_steps)), 1e-12) << what << " " << z;
      }
      Complex sum = 0.0;  // all roots, not one several times: their sum is R alpha_1
      for (const Complex& root : zeta) sum += root;
      std::vector<Complex> increments, past(m.alpha.size(), 0.0);
      past[0] = 1.0;
      EXPECT_LT(std::abs(sum - test::linear_step(m, z, past, increments)), 1e-12) << what << " " << z;
    }
  }
}

TEST(Stability, HoldsAllOverTheLeftHalfPlane) {
  int num_unstable = 0;
  for (const auto& [what, m] : all_methods()) {
    double largest = 0.0;
    for (int k = 0; k < 60; ++k) {
      const double size = std::pow(10.0, -2.0 + 0.1 * k);
      for (int angle = 0; angle <= 24; ++angle) {
        largest = std::max(largest, largest_modulus(m, std::polar(size, M_PI / 2 * (1.0 + angle / 24.0))));
      }
    }
    EXPECT_EQ(m.stability != Stability::not_a_stable, largest < 1.0 + 1e-9) << what << " " << largest;
    if (m.stability == Stability::not_a_stable) ++num_unstable;
  }
  EXPECT_GE(num_unstable, 2);
}

TEST(Stability, DampingAtInfinityIsTheLimit) {
  for (const auto& [what, m] : all_methods()) {
    const double rest = 1e-10;  // R(z) - R(inf) = b^T A^-2 (1, ..., 1) / z, the first factor below 100
    EXPECT_NEAR(largest_modulus(m, -1e12), std::abs(m.R_infinity), std::pow(rest, 1.0 / m.num_steps)) << what;
    if (m.num_steps == 1) {
      EXPECT_NEAR(amplification(m, -1e12)[0].real(), m.R_infinity, rest) << what;
    }
  }
}

// What docs/methods.md says of undamped modes, lambda = i omega, and of damping in proportion to stiffness,
// lambda = -omega^2 tau/2 + i omega sqrt(1 - (omega tau/2)^2).
TEST(Stability, ThirdOrderBackwardDifferentiationMakesUndampedModesGrow) {
  const Method& bdf3 = *find_method("bdf3");
  EXPECT_NEAR(largest_modulus(bdf3, {0.0, 1.14}), 1.0456, 1e-4);
  EXPECT_NEAR((largest_modulus(bdf3, {0.0, 0.05}) - 1.0) / std::pow(0.05, 4), 0.25, 1e-3);
  const auto largest_growth = [&](double damping_time, double from, double to) {  // in steps
    double largest = 0.0;
    for (int k = 0; k <= 1000; ++k) {
      const double y = from + (to - from) * k / 1000, ratio = 0.5 * y * damping_time;
      largest = std::max(largest, largest_modulus(bdf3, y * Complex(-ratio, std::sqrt(1.0 - ratio * ratio))));
    }
    return largest;
  };
  EXPECT_NEAR(largest_growth(0.0, 0.1, 3.0), 1.0456, 1e-4) << "the most at any step";
  EXPECT_GT(largest_growth(0.0, 1.92, 1.93), 1.0);
  EXPECT_LT(largest_growth(0.0, 1.94, 100.0), 1.0);
  EXPECT_GT(largest_growth(0.141, 0.1, 3.0), 1.0);
  EXPECT_LT(largest_growth(0.143, 0.1, 3.0), 1.0);
}

TEST(Stability, RootCondition) {
  const auto stable = [](std::vector<double> alpha) { return is_zero_stable({"", std::move(alpha), 1.0, {}, {}, ""}); };
  EXPECT_TRUE(stable({1}));
  EXPECT_TRUE(stable({0, 1})) << "1 and -1, both simple";
  EXPECT_TRUE(stable({1, 0, 0, 0, 0, 0})) << "0 five times is inside";
  EXPECT_FALSE(stable({-1, 2})) << "-2";
  EXPECT_FALSE(stable({2, -1})) << "1 twice";
  EXPECT_FALSE(stable({-1, 1, 1})) << "-1 twice";
  EXPECT_TRUE(stable({360. / 147, -450. / 147, 400. / 147, -225. / 147, 72. / 147, -10. / 147})) << "BDF of six steps";
  // BDF of seven steps (coefficients over 1089/420)
  EXPECT_FALSE(
      stable({2940. / 1089, -4410. / 1089, 4900. / 1089, -3675. / 1089, 1764. / 1089, -490. / 1089, 60. / 1089}));
}

}  // namespace
}  // namespace pliant::test_linear_stability
