// Derivatives of formulas in time, and their kinks.
#include "base/expression.hpp"
#include "base/formula_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_formula_tree {
namespace {

constexpr double x = 0.3, y = -1.2, z = 2.5;

/// Every function, operator and constant of the grammar, and what binds more tightly than what.
const std::vector<std::string> formulas{
    "t",
    "sin(2*t)",
    "cos(t^2)",
    "tan(t/2)",
    "asin(t/3)",
    "acos(0.2*t)",
    "atan(3*t)",
    "atan2(t, 1 - t^2)",
    "sinh(t)",
    "cosh(2*t)",
    "tanh(t - 1)",
    "asinh(4*t)",
    "acosh(1.5 + t)",
    "atanh(t/4)",
    "log2(1 + t)",
    "log10(2 + t)",
    "log(3 + t)",
    "ln(t^2 + 1)",
    "exp(-t)",
    "sqrt(1 + t)",
    "sign(t - 0.1)*t^3",
    "rint(t)*t + t^2",
    "abs(t - 5)*t",
    "sum(t, t^2, 3)",
    "avg(t, t^3)",
    "min(t^2, 7, 3*t)",
    "max(t, t^2/4, 0.01)",
    "-t^2",
    "2^-t^2",
    "t^3^0.5",
    "-2*t - -t",
    "3 - t - 1 - t",
    "8/t/2/t",
    "2*t^2/3*t",
    "t^t",
    "(1 + t)^(x*t)",
    "t^x*y - z/t",
    "t < 0.5 ? t : t^2",
    "t <= 0.4 ? 1 : t > 3 ? 2 : t^2",
    "(t >= 0.1 && t != 9)*t^2",
    "(t == 9 || t < 100)*t^3",
    "1 + 1 ? t : -t",
    "1 < t + 2 && t + 2 < 3 ? t^2 : t",
    ".5*t + 5.*t + 1e-1*t^2 + 2E+0",
    "_pi*t + pi*t^2 + _e",
    "t>0.3?(t<0.35?1:t^2):-t",
};

class Derivatives : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Grammar, Derivatives, testing::ValuesIn(formulas),
                         [](const auto& of) { return "Formula" + std::to_string(of.index); });

// Differences of the eighth order of what muParser computes.
TEST_P(Derivatives, AreThoseOfWhatMuParserComputes) {
  const Expression formula(GetParam(), 3.0);
  for (const double t : {0.37, 0.83, 1.9}) {
    const TimeJet jet = formula.derivatives(x, y, z, t, t - 1e-9);
    const double h = 2e-3;
    const auto f = [&](int k) { return formula(x, y, z, t + k * h); };
    const double size = 1.0 + std::abs(f(0));
    EXPECT_NEAR(jet.value, f(0), 1e-14 * size);
    const double first =
        0.8 * (f(1) - f(-1)) - 0.2 * (f(2) - f(-2)) + 4.0 / 105 * (f(3) - f(-3)) - 1.0 / 280 * (f(4) - f(-4));
    const double second = -205.0 / 72 * f(0) + 1.6 * (f(1) + f(-1)) - 0.2 * (f(2) + f(-2)) +
                          8.0 / 315 * (f(3) + f(-3)) - 1.0 / 560 * (f(4) + f(-4));
    EXPECT_NEAR(jet.rate, first / h, 1e-10 * (size + std::abs(jet.rate))) << t;
    EXPECT_NEAR(jet.acceleration, second / (h * h), 1e-7 * (size + std::abs(jet.acceleration))) << t;
  }
}

// Nothing is divided by zero where a power begins.
TEST(FormulaTree, PowersHaveDerivativesAtZero) {
  const TimeJet square = Expression("t^2").derivatives(0, 0, 0, 0.0, 1e-9);
  EXPECT_EQ(square.rate, 0.0);
  EXPECT_EQ(square.acceleration, 2.0);
  EXPECT_EQ(Expression("t^1").derivatives(0, 0, 0, 0.0, 1e-9).acceleration, 0.0);
  EXPECT_EQ(Expression("sqrt(0*t)").derivatives(0, 0, 0, 0.0, 1e-9).rate, 0.0);
}

TEST(FormulaTree, AtAKinkTheSideDecides) {
  struct Case {
    std::string formula;
    double kink, before, after;  // rates
  };
  const std::vector<Case> cases{{"min(t/0.1, 1)", 0.1, 10.0, 0.0},       {"max(0, 3*(t - 0.2))", 0.2, 0.0, 3.0},
                                {"abs(t - 0.3)", 0.3, -1.0, 1.0},        {"t < 0.4 ? 2*t : 0.8", 0.4, 2.0, 0.0},
                                {"(t >= 0.5)*(t - 0.5)", 0.5, 0.0, 1.0}, {"sign(t - 0.25)*(t - 0.25)", 0.25, -1.0, 1.0},
                                {"min(x + t, x + 0.1)", 0.1, 1.0, 0.0}};
  for (const auto& [text, kink, before, after] : cases) {
    const Expression formula(text);
    EXPECT_NEAR(formula.derivatives(x, y, z, kink, kink - 1e-9).rate, before, 1e-14) << text;
    EXPECT_NEAR(formula.derivatives(x, y, z, kink, kink + 1e-9).rate, after, 1e-14) << text;
  }
}

TEST(Kinks, AreFoundToTheLastDigit) {
  struct Case {
    std::string formula;
    std::vector<double> kinks;
  };
  const std::vector<Case> cases{
      {"0.1*min(t/0.105, 1)", {0.105}},
      {"t < 0.1 ? 0 : 1", {0.1}},
      {"t > 0.1", {0.1}},
      {"min(t/0.1, 1) - max(0, t - 0.7)", {0.1, 0.7}},
      {"max(0, sin(2*pi*t))", {0.5, 1.0}},
      {"abs(t - 0.3) + abs(t - 0.3000007)", {0.3, 0.3000007}},
      {"rint(4*t)", {0.125, 0.375, 0.625, 0.875}},
      {"(t >= 0.2)*(t < 0.21)*50", {0.2, 0.21}},
      {"min(1, x)*min(t, 0.25)", {0.25}},
      {"t < 0.3 ? t : t <= 0.6 ? 0.3 : 0.9 - t", {0.3, 0.6}},
      {"t < 0.1 ? 0 : (t - 0.1)^2", {0.1}},  // the acceleration jumps
      {"t < 0.1 ? 0 : (t - 0.1)^5", {}},     // smooth enough for all
      {"abs(t - 0.4)^5", {}},
      {"abs(sin(pi*t))", {1.0}},  // at the ends alone, and the start is none
      {"max(t, -1)", {}},
      {"min(x*t, 0.5*t)", {}},  // another at each place
      {"sin(20*t)", {}},
      {"min(t, 1)", {1.0}},  // of importance to what goes on from there
      {"t < 1 ? 2 : 3", {1.0}},
      {"min(t, 1.0001)", {}},
      {"x > 0.5", {}},
      {"t == 0.25", {}},
      {"(t >= 0.2)*(t < 0.20001)*50", {0.2, 0.20001}},  // shorter than the interval, but linear in t
      {"t > 0.2 && t < 0.20001 ? 1 : 0", {0.2, 0.20001}},
      {"max(0, 1 - abs((t - 0.5)/1e-5))", {0.49999, 0.5, 0.50001}},
  };
  for (const auto& [text, expected] : cases) {
    const auto found = Expression(text, 1000.0).kinks(1.0, 1.0 / 300);
    ASSERT_EQ(found.size(), expected.size()) << text;
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], expected[k], 4e-16) << text;
  }
}

TEST(FormulaTree, FindsKinksThatDependOnThePlace) {
  const std::array<double, 3> X{0.25, -0.5, 2.0};
  for (const auto& [text, expected] :
       std::vector<std::pair<const char*, std::vector<double>>>{{"min(t, x)", {0.25}},
                                                                {"t < x/2 ? 0 : 1", {0.125}},
                                                                {"abs(t + y) + max(0, t - 2*x)", {0.5, 0.5}},
                                                                {"max(0, t - x)^5", {}},
                                                                {"min(t, 0.3)*x", {}},  // at the same time everywhere
                                                                {"x > 0.2 ? t : 2*t", {}},  // at no time
                                                                {"min(t, z)", {}},          // not before the end
                                                                {"x*t*sin(y)", {}}}) {
    const auto found = Expression(text).kinks_at(X, 1.0, 1e-3);
    const std::set<double> times(expected.begin(), expected.end());
    ASSERT_EQ(found.size(), times.size()) << text;
    EXPECT_TRUE(std::ranges::equal(found, times, [](double a, double b) { return std::abs(a - b) <= 4e-16; })) << text;
  }
}

// Neither long formulas nor deep ones reach the end of the stack.
TEST(FormulaTree, TakesLongFormulasAndRefusesDeepOnes) {
  std::string sum = "t";
  for (int k = 0; k < 9000; ++k) sum += "+t";
  EXPECT_EQ(Expression(sum).derivatives(0, 0, 0, 0.5, 0.4).rate, 9001.0);
  for (const char* open : {"(", "-(", "t^(", "t?1:("}) {
    const std::size_t depth = 15000 / std::string(open).size() / 2;
    std::string deep;
    for (std::size_t k = 0; k < depth; ++k) deep += open;
    EXPECT_THROW(Expression(deep + "t" + std::string(depth, ')')), ExpressionError) << open;
  }
}

// What flickers costs no more than it must.
TEST(Kinks, OfNoiseComeToAnEnd) {
  EXPECT_GT(Expression("rint(1e8*t)").kinks(1.0, 1e-3).size(), 1000u);
}

}  // namespace
}  // namespace pliant::test_formula_tree
