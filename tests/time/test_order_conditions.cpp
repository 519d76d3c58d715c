// What is derived from coefficients is measured: orders, error constants, embedded formulas.
#include "time/formula.hpp"
#include "time/order_conditions.hpp"

#include <cmath>
#include <numeric>

namespace pliant::test_order_conditions {
namespace {

using test::all_methods;
using test::Rate;

double measured_order(const Method& method, Rate rate) {
  constexpr int num_steps = 320;
  return std::log2(test::error_of_viscous_motion(method, rate, num_steps) /
                   test::error_of_viscous_motion(method, rate, 2 * num_steps));
}

/// An order told as 3 may be more.
void expect_order(const std::string& what, int told, double measured) {
  constexpr double tolerance = 0.1;  // of slopes at finite steps
  EXPECT_GT(measured, told - tolerance) << what;
  if (told < 3) {
    EXPECT_LT(measured, told + tolerance) << what;
  }
}

TEST(Order, IsTheMeasuredOne) {
  for (const auto& [what, m] : all_methods()) expect_order(what, m.order, measured_order(m, Rate::exact));
}

TEST(Order, OfReconstructedRatesIsTheMeasuredOne) {
  for (const auto& [what, m] : all_methods()) {
    expect_order(what, m.reconstructed_rate_order, measured_order(m, Rate::reconstructed));
  }
}

/// Numbers of one short step of y' = y with exact past states.
struct LinearStep {
  double z, error, difference;
};

LinearStep linear_step(const Method& m, double z) {
  std::vector<std::complex<double>> past, increments;
  for (int r = 0; r < m.num_steps; ++r) past.emplace_back(std::exp(-r * z));
  LinearStep step{z, (test::linear_step(m, z, past, increments) - std::exp(z)).real(), 0.0};
  for (std::size_t i = 0; i < m.bt_embedded.size(); ++i) {
    step.difference += (m.bt[i] - m.bt_embedded[i]) * increments[i].real();
  }
  return step;
}

TEST(ErrorConstant, IsThatOfAShortStep) {
  for (const auto& [what, m] : all_methods()) {
    const LinearStep step = linear_step(m, 0.01);
    const double size = std::pow(step.z, m.order + 1);
    // The next term of the series is smaller by the step and factors of a few.
    EXPECT_NEAR(step.error / size, m.error_constant, 0.05 * std::max(0.1, std::abs(m.error_constant))) << what;
  }
}

TEST(ErrorConstant, OfBackwardDifferentiationIsTheClassicalOne) {
  for (const Method& m : methods()) {
    if (m.num_stages > 1 || !m.stiffly_accurate) continue;
    EXPECT_NEAR(m.error_constant, m.beta / (m.num_steps + 1), 1e-14) << m.name;
  }
}

TEST(Embedded, DifferenceHasItsOrderAndConstant) {
  int num_embedded = 0;
  for (const auto& [what, m] : all_methods()) {
    if (m.bt_embedded.empty()) continue;
    ++num_embedded;
    const LinearStep step = linear_step(m, 0.01);
    EXPECT_NEAR(step.difference / std::pow(step.z, m.embedded_order + 1), m.embedded_error,
                0.1 * std::abs(m.embedded_error))
        << what;
    EXPECT_LT(m.embedded_order, m.order) << what;
    // Large enough to be seen, small enough to be no nuisance; fast modes are not amplified.
    EXPECT_GE(std::abs(m.embedded_error), 0.05) << what;
    EXPECT_LE(std::abs(m.embedded_error), 0.1 + 1e-12) << what;
    const double R_embedded = 1.0 - std::accumulate(m.bt_embedded.begin(), m.bt_embedded.end(), 0.0);
    EXPECT_LE(std::abs(R_embedded), std::max(0.75, std::abs(m.R_infinity)) + 1e-12) << what;
  }
  EXPECT_GE(num_embedded, 4);
}

// The conditions of order 1 and 2 in the slopes' weights b^ = A^T bt^.
TEST(Embedded, FulfilsTheConditionsOfItsOrder) {
  for (const auto& [what, m] : all_methods()) {
    if (m.bt_embedded.empty()) continue;
    double sum = 0.0, moment = 0.0;
    for (std::size_t j = 0; j < m.b.size(); ++j) {
      double b_j = 0.0;
      for (std::size_t i = 0; i < m.b.size(); ++i) b_j += m.bt_embedded[i] * m.A[i][j];
      sum += b_j;
      moment += b_j * m.c[j];
    }
    EXPECT_NEAR(sum, 1.0, 1e-13) << what;
    EXPECT_EQ(std::abs(moment - 0.5) < 1e-13, m.embedded_order == 2) << what;
  }
}

// Where the stages allow it, fast modes do not enter the difference at all.
TEST(Embedded, FreedomIsSpentOnFastModes) {
  const double g = 0.25;  // the L-stable method of five stages and order 4 of Hairer & Wanner II, table IV.6.5
  const Method m = test::method_of({1}, 1,
                                   {{g, 0, 0, 0, 0},
                                    {0.5, g, 0, 0, 0},
                                    {17. / 50, -1. / 25, g, 0, 0},
                                    {371. / 1360, -137. / 2720, 15. / 544, g, 0},
                                    {25. / 24, -49. / 48, 125. / 16, -85. / 12, g}},
                                   {25. / 24, -49. / 48, 125. / 16, -85. / 12, g});
  EXPECT_EQ(m.order, 3) << "told up to 3";
  EXPECT_TRUE(m.stiffly_accurate);
  EXPECT_EQ(m.stability, Stability::l_stable);
  EXPECT_EQ(m.embedded_order, 2);
  EXPECT_NEAR(std::accumulate(m.bt_embedded.begin(), m.bt_embedded.end(), 0.0), 1.0, 1e-12);
}

}  // namespace
}  // namespace pliant::test_order_conditions
