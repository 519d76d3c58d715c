#include "time/bdf.hpp"
#include "time/every_method.hpp"
#include "time/formula.hpp"
#include "time/method.hpp"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

namespace pliant::test_method {
namespace {

struct Expected {
  int num_steps, num_stages, order;
  Stability stability;
  double R_infinity;
  bool stiffly_accurate, symplectic;
  int reconstructed_rate_order, embedded_order;
  double error_constant;
  bool adaptive;
};

const double g = 0.43586652150845899941601945;
const double g22 = 1.0 - std::sqrt(0.5);
const double g23 = 0.5 + 0.5 / std::sqrt(3.0);
// Error constants of several stages: the series of P(z)/(1 - gz)^s - e^z, P given by the order.
const std::map<std::string, Expected> expected = {
    {"backward-euler", {1, 1, 1, Stability::l_stable, 0.0, true, false, 1, 0, 1.0 / 2, true}},
    {"bdf2", {2, 1, 2, Stability::a_stable, 0.0, true, false, 2, 0, 2.0 / 9, true}},
    {"bdf3", {3, 1, 3, Stability::not_a_stable, 0.0, true, false, 3, 0, 3.0 / 22, true}},
    {"dirk22", {1, 2, 2, Stability::l_stable, 0.0, true, false, 2, 1, g22* g22*(3 - 2 * g22) - 1.0 / 6, true}},
    {"dirk23",
     {1, 2, 3, Stability::a_stable, 1.0 - std::sqrt(3.0), false, false, 1, 1, g23* g23*(1.5 - 2 * g23) - 1.0 / 24,
      true}},
    {"dirk33", {1, 3, 3, Stability::l_stable, 0.0, true, false, 2, 2, g* g*(3 - 8 * g + 3 * g * g) - 1.0 / 24, true}},
    {"implicit-midpoint", {1, 1, 2, Stability::a_stable, -1.0, false, true, 1, 0, 1.0 / 12, false}},
    {"symplectic-dirk22", {1, 2, 2, Stability::a_stable, 1.0, false, true, 2, 0, 1.0 / 48, false}},
};

class MethodRows : public test::EveryMethod {};

TEST_P(MethodRows, HasThePropertiesOfTheLiterature) {
  const Method& m = GetParam();
  ASSERT_TRUE(expected.contains(m.name)) << "a new method: add its properties here";
  const Expected& e = expected.at(m.name);
  EXPECT_EQ(m.num_steps, e.num_steps);
  EXPECT_EQ(m.num_stages, e.num_stages);
  EXPECT_EQ(m.order, e.order);
  EXPECT_EQ(m.stability, e.stability) << to_string(m.stability);
  EXPECT_NEAR(m.R_infinity, e.R_infinity, 1e-14);
  EXPECT_EQ(m.stiffly_accurate, e.stiffly_accurate);
  EXPECT_EQ(m.symplectic, e.symplectic);
  EXPECT_FALSE(m.summary.empty());
  EXPECT_EQ(m.reconstructed_rate_order, e.reconstructed_rate_order);
  EXPECT_EQ(m.embedded_order, e.embedded_order);
  EXPECT_EQ(m.bt_embedded.empty(), e.embedded_order == 0);
  EXPECT_NEAR(m.error_constant, e.error_constant, 1e-14);
  EXPECT_FALSE(m.needs_equal_steps);
  EXPECT_EQ(!why_not_adaptive(m).has_value(), e.adaptive);
}

// At_i A_{1:i-1,1:i-1} = A_{i,1:i-1} and bt^T A = b^T: the reconstruction is the Runge-Kutta formula without its
// slopes.
TEST_P(MethodRows, ReconstructionWeightsReproduceTheCoefficients) {
  const Method& m = GetParam();
  for (std::size_t j = 0; j < m.b.size(); ++j) {
    double b_j = 0.0;
    for (std::size_t i = 0; i < m.b.size(); ++i) {
      b_j += m.bt[i] * m.A[i][j];
      if (j >= i) continue;
      double A_ij = 0.0;
      for (std::size_t k = 0; k < i; ++k) A_ij += m.At[i][k] * m.A[k][j];
      EXPECT_NEAR(A_ij, m.A[i][j], 1e-15);
    }
    EXPECT_NEAR(b_j, m.b[j], 1e-15);
  }
}

INSTANTIATE_TEST_SUITE_P(Table, MethodRows, test::every_method(), test::method_name);

TEST(Methods, HoldsEveryNameOnce) {
  EXPECT_EQ(methods().size(), expected.size());
  for (const auto& [name, e] : expected) {
    const Method* m = find_method(name);
    ASSERT_NE(m, nullptr) << name;
    EXPECT_EQ(m->name, name);
  }
  EXPECT_EQ(find_method("bdf4"), nullptr);
}

// The third-order SDIRK of the literature: g, b1, c2 as printed there.
TEST(Methods, Dirk33HasThePublishedDigits) {
  const Method& m = *find_method("dirk33");
  EXPECT_NEAR(m.A[0][0], 0.435866521508458999416019, 1e-16);
  EXPECT_NEAR(m.b[0], 1.20849664917601007033648, 1e-15);
  EXPECT_NEAR(m.c[1], 0.717933260754229499708010, 1e-15);
}

std::string refusal(const MethodRow& row) {
  const auto result = derive_method(row);
  const auto* refused = std::get_if<MethodRefusal>(&result);
  return refused != nullptr ? refused->reason : "";
}

MethodRow row(std::vector<double> alpha, double beta, std::vector<std::vector<double>> A, std::vector<double> b) {
  return {"m", std::move(alpha), beta, std::move(A), std::move(b), ""};
}

TEST(DeriveMethod, RefusesWhatTheLayerCannotRunAndSaysWhy) {
  const auto expect = [](const MethodRow& bad, const std::string& reason) {
    EXPECT_NE(refusal(bad).find(reason), std::string::npos)
        << "'" << refusal(bad) << "' does not say '" << reason << "'";
  };
  const double x = std::sqrt(3.0) / 6;
  expect(row({1}, 1, {{0, 0}, {0.5, 0.5}}, {0.5, 0.5}), "stage 1 is explicit");  // trapezoidal rule
  expect(row({1}, 1, {{0.25, 0.25 - x}, {0.25 + x, 0.25}}, {0.5, 0.5}), "stage 1 depends on stage 2");  // Gauss
  expect(row({1}, 1, {{-1}}, {1}), "negative on its diagonal");
  expect(row({1}, 1, {{1}}, {0.9}), "b sums to 0.9 instead of 1");
  expect(row({0.9}, 1, {{1}}, {1}), "alpha sums to 0.9 instead of 1");
  expect(row({1}, 0.9, {{1}}, {1}), "beta must be 1");
  expect(row({0.5, 0.5}, 1, {{1}}, {1}), "beta must be 1.5");
  expect(row({1}, -1, {{1}}, {1}), "beta must be positive");
  expect(row({1}, 1, {{1, 0}}, {1}), "square");
  expect(row({}, 1, {{1}}, {1}), "past state");
  expect(row({1}, 1, {}, {}), "square");
  expect(row({1}, 1, {{std::nan("")}}, {1}), "finite");
  expect(row({1}, INFINITY, {{1}}, {1}), "finite");
  expect(row({1, 0}, 1, {{1}}, {1}), "ends in a zero");
  expect(row({-1, 2}, 3, {{1}}, {1}), "not zero-stable");
  expect(row({-1, 1, 1}, 4, {{1}}, {1}), "not zero-stable");
  expect(row({0.4, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1}, 3.1, {{1}}, {1}), "7 past states");
  std::vector<std::vector<double>> A(11, std::vector<double>(11, 0.0));
  for (std::size_t i = 0; i < A.size(); ++i) A[i][i] = 1;
  expect(row({1}, 1, A, std::vector<double>(11, 1.0 / 11)), "11 stages");
  EXPECT_EQ(refusal(row({4. / 3, -1. / 3}, 2. / 3, {{1}}, {1})), "");
}

// SDIRK34 of Norsett (A-stable, order 4; told as 3), whose R(infinity) is known: a row is all it takes.
TEST(DeriveMethod, DerivesANewRow) {
  const double a = std::cos(M_PI / 18) / std::sqrt(3.0) + 0.5, q = 1 / (6 * (2 * a - 1) * (2 * a - 1));
  const Method m = test::method_of({1}, 1, {{a, 0, 0}, {0.5 - a, a, 0}, {2 * a, 1 - 4 * a, a}}, {q, 1 - 2 * q, q});
  EXPECT_EQ(m.order, 3);
  EXPECT_EQ(m.stability, Stability::a_stable);
  EXPECT_NEAR(m.R_infinity, -0.630415, 1e-6);
  EXPECT_NEAR(m.error_constant, 0.0, 1e-14);
  // The other root of the two-stage method of order 3, (3 - sqrt 3)/6, is not A-stable.
  const double h = (3 - std::sqrt(3.0)) / 6;
  const Method other = test::method_of({1}, 1, {{h, 0}, {1 - 2 * h, h}}, {0.5, 0.5});
  EXPECT_EQ(other.order, 3);
  EXPECT_EQ(other.stability, Stability::not_a_stable);
}

TEST(DeriveMethod, KnowsBackwardDifferentiationInAnyDigits) {
  const Method bdf2 = test::method_of({4. / 3 + 1e-11, -1. / 3 - 1e-11}, 2. / 3 - 1e-11, {{1}}, {1});
  EXPECT_FALSE(bdf2.needs_equal_steps);
  EXPECT_EQ(bdf2.max_growth, 1 + std::sqrt(2.0));
  EXPECT_FALSE(why_not_adaptive(bdf2).has_value());
  // Four steps: what changing steps do to its stability is not known.
  const Method bdf4 = test::method_of({48. / 25, -36. / 25, 16. / 25, -3. / 25}, 12. / 25, {{1}}, {1});
  EXPECT_EQ(bdf4.order, 3) << "told up to 3";
  EXPECT_EQ(bdf4.stability, Stability::not_a_stable);
  EXPECT_TRUE(bdf4.needs_equal_steps);
  EXPECT_EQ(bdf4.max_growth, 1.0);
}

TEST(DeriveMethod, SaysWhyStepsCannotAdapt) {
  const auto expect = [](const Method& m, const std::string& reason) {
    EXPECT_NE(why_not_adaptive(m).value_or("").find(reason), std::string::npos) << why_not_adaptive(m).value_or("");
  };
  expect(*find_method("implicit-midpoint"), "symplectic");
  expect(*find_method("symplectic-dirk22"), "symplectic");
  expect(test::method_of({1.2, -0.2}, 0.8, {{0.6875}}, {1}), "equal steps");
  expect(test::method_of({1}, 1, {{0.7}}, {1}), "too few stages");
  // Norsett's is told by its embedded formula, backward differentiation by its own rates.
  EXPECT_FALSE(why_not_adaptive(test::own_methods()[0].method).has_value());
  EXPECT_EQ(estimate_order(test::own_methods()[0].method), 3);
  EXPECT_EQ(estimate_order(*find_method("bdf3")), 3);
  EXPECT_EQ(estimate_order(*find_method("dirk23")), 2);
}

TEST(Bdf, WeightsOfEqualStepsAreTheTables) {
  for (const Method& m : methods()) {
    if (m.num_stages > 1 || !m.stiffly_accurate) continue;
    std::vector<double> past_times;  // times that rounding has touched
    for (int r = 0; r < m.num_steps; ++r) past_times.push_back((1000 - r) * 0.1);
    const BdfWeights w = bdf_weights(past_times, {1001 * 0.1, 0.1});
    ASSERT_EQ(w.alpha().size(), m.alpha.size());
    EXPECT_NEAR(w.beta, m.beta, 1e-15);
    for (std::size_t r = 0; r < w.alpha().size(); ++r) EXPECT_NEAR(w.alpha()[r], m.alpha[r], 4e-15);
    past_times.clear();
    for (int r = 0; r < m.num_steps; ++r) past_times.push_back((77 - r) * 0.1);
    EXPECT_EQ(bdf_weights(past_times, {78 * 0.1, 0.1}).beta, w.beta) << "to the last bit";
  }
}

TEST(Bdf, WeightsOfTwoStepsFollowTheKnownFormula) {
  for (double w : {0.3, 1.0, 2.0}) {
    const BdfWeights got = bdf_weights(std::vector{5.0, 5.0 - 1.0 / w}, {6.0, 1.0});
    EXPECT_NEAR(got.alpha()[0], (1 + w) * (1 + w) / (1 + 2 * w), 1e-14);
    EXPECT_NEAR(got.alpha()[1], -w * w / (1 + 2 * w), 1e-14);
    EXPECT_NEAR(got.beta, (1 + w) / (1 + 2 * w), 1e-14);
  }
}

TEST(Bdf, ThreeStepsAreExactForCubics) {
  const std::vector<double> past_times{2.0, 1.3, 0.4};
  const BdfWeights w = bdf_weights(past_times, {2.8, 0.8});
  for (int k = 0; k <= 3; ++k) {
    double y = w.beta * 0.8 * k * std::pow(2.8, k - 1);
    for (std::size_t r = 0; r < 3; ++r) y += w.alpha()[r] * std::pow(past_times[r], k);
    EXPECT_NEAR(y, std::pow(2.8, k), 1e-13) << "power " << k;
  }
}

TEST(Bdf, StatesAcrossTooSharpAGrowthAreNotUsed) {
  const auto usable = [](std::vector<double> past_times, double dt) {
    return num_usable_states(past_times, {past_times.front() + dt, dt});
  };
  EXPECT_EQ(usable({0.0}, 1.0), 1);
  EXPECT_EQ(usable({0.0, -1.0}, 2.4), 2);
  EXPECT_EQ(usable({0.0, -1.0}, 2.5), 1);
  EXPECT_EQ(usable({0.0, -1.0, -2.0}, 1.5), 3);
  EXPECT_EQ(usable({0.0, -1.0, -2.0}, 2.0), 2);
  EXPECT_EQ(usable({0.0, -2.0, -3.0}, 2.0), 2) << "the jump is one step back";
  EXPECT_EQ(usable({0.0, -0.1, -0.2}, 0.001), 3) << "shrinking is safe";
}

}  // namespace
}  // namespace pliant::test_method
