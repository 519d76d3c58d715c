#include "base/expression.hpp"
#include "base/formula_tree.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_expression {
namespace {

constexpr double x = 0.3, y = -1.2, z = 2.5, t = 0.7;

TEST(Expression, EvaluatesLikeCxx) {
  const std::vector<std::pair<std::string, double>> cases{
      {"x", x},
      {"t", t},
      {"-100*sin(2*pi*t)", -100 * std::sin(2 * std::numbers::pi * t)},
      {"x^2 + y*z - t/4", x * x + y * z - t / 4},
      {"-x^2", -x * x},
      {"2^3^2 + 0*x", 512},
      {"x < 1e-9", 0},
      {"x > 0 && y < 0", 1},
      {"t == 0.7 ? x : y", x},
      {"t != 0.7", 0},
      {"t <= 0.7", 1},
      {"ln(z) + log(z)", 2 * std::log(z)},
      {"log10(z) + log2(z)", std::log10(z) + std::log2(z)},
      {"min(x, y, z) + max(x, y, z)", y + z},
      {"atan2(y, x)", std::atan2(y, x)},
      {" x\n + y\t", x + y},
  };
  for (const auto& [text, value] : cases) {
    EXPECT_NEAR(Expression(text)(x, y, z, t), value, 1e-14 * std::max(1.0, std::abs(value))) << text;
  }
}

TEST(Expression, FactorMultipliesTheValueButNotTheText) {
  const Expression e("2*x", 1000);
  EXPECT_DOUBLE_EQ(e(x, y, z, t), 2000 * x);
  EXPECT_EQ(e.text(), "2*x");
  EXPECT_DOUBLE_EQ(Expression("3", 10)(x, y, z, t), 30);
}

TEST(Expression, KnowsWhatItDependsOn) {
  EXPECT_TRUE(Expression("y").depends_on_space());
  EXPECT_FALSE(Expression("y").depends_on_time());
  EXPECT_FALSE(Expression("2*t").depends_on_space());
  EXPECT_TRUE(Expression("2*t").depends_on_time());
  EXPECT_FALSE(Expression("2*pi").depends_on_time());
  EXPECT_TRUE(Expression().is_zero());
  EXPECT_TRUE(Expression("1 - 1").is_zero());
  EXPECT_FALSE(Expression("0*t").is_zero()) << "a formula is not analysed";
}

TEST(Expression, TextOfAConstantReadsBackExactly) {
  for (const double value : {0.0, 1.0 / 3.0, -1e-300, 6.02e23}) {
    EXPECT_EQ(Expression(Expression(value).text())(0, 0, 0, 0), value);
  }
  EXPECT_EQ(Expression("2*pi").text(), Expression(2 * std::numbers::pi).text());
}

TEST(Expression, CopiesAreIndependentOfTheOriginal) {
  auto original = std::make_unique<Expression>("x + t");
  const Expression copy = *original;
  Expression assigned;
  assigned = *original;
  EXPECT_EQ((*original)(5, 0, 0, 5), 10);
  EXPECT_EQ(copy(1, 0, 0, 1), 2);
  original.reset();
  EXPECT_EQ(copy(1, 0, 0, 2), 3);
  const Expression moved = std::move(assigned);
  EXPECT_EQ(moved(1, 0, 0, 3), 4);
  std::vector<Expression> many(3, copy);
  many.resize(100);
  EXPECT_EQ(many[2](1, 0, 0, 4), 5);
}

TEST(Expression, ReplacesAllCopiesOfAReplaceableFormula) {
  Expression given("3*t");
  const Expression before = given;
  given.make_replaceable();
  Expression copy = given;
  const Expression negative = copy.scaled(-2.0), moved = std::move(copy), frozen = given.frozen();
  EXPECT_EQ(negative(x, y, z, t), -6.0 * t);
  given.replace(Expression("x + t^2", 10.0));
  EXPECT_EQ(given(x, y, z, t), 10.0 * (x + t * t));
  EXPECT_EQ(moved(x, y, z, t), 10.0 * (x + t * t));
  EXPECT_EQ(negative(x, y, z, t), -20.0 * (x + t * t));
  EXPECT_TRUE(negative.depends_on_space());
  EXPECT_NEAR(negative.derivatives(x, y, z, t, t).rate, -40.0 * t, 1e-12);
  negative.replace(Expression(0.0));
  EXPECT_TRUE(given.is_zero());
  EXPECT_FALSE(moved.depends_on_time());
  for (const Expression* apart : {&before, &frozen}) {
    EXPECT_FALSE(apart->is_replaceable());
    EXPECT_EQ((*apart)(x, y, z, t), 3.0 * t);
  }
}

TEST(Expression, ScalesWithTheFactorOfItsUnit) {
  EXPECT_EQ(Expression("2*x", 1e-3).scaled(-1.0)(x, y, z, t), -2e-3 * x);
  EXPECT_EQ(Expression(4.0).scaled(0.5)(x, y, z, t), 2.0);
}

TEST(Expression, MayReturnWhatTheFormulaDoes) {
  EXPECT_TRUE(std::isinf(Expression("1/x")(0, 0, 0, 0)));
  EXPECT_TRUE(std::isnan(Expression("sqrt(x)")(-1, 0, 0, 0)));
  EXPECT_TRUE(std::isinf(Expression("1/0")(0, 0, 0, 0)));
}

struct Bad {
  const char* text;
  int position;
  const char* message;
};

class BadExpression : public testing::TestWithParam<Bad> {};

TEST_P(BadExpression, IsRefusedWithItsPosition) {
  const auto& [text, position, message] = GetParam();
  try {
    const Expression refused{std::string(text)};
    FAIL() << text;
  } catch (const ExpressionError& error) {
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << text << ": " << error.what();
    EXPECT_EQ(error.position(), position) << text << ": " << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Formulas, BadExpression,
    testing::Values(Bad{"", 0, "empty"}, Bad{"x = 3", 2, "cannot assign"}, Bad{"x+=3", 2, "cannot assign"},
                    Bad{"1, 2", 1, "one value"}, Bad{"2,5*x", 1, "decimal point"},
                    Bad{"2**x", 2, "a power is written '^'"}, Bad{"2*foo", 2, "'foo' is not known"},
                    Bad{"2*sine(x)", 2, "did you mean 'sin'?"}, Bad{"x(1)", 0, "'x' is not a function"},
                    Bad{"x+)", 2, "parenthesis"}, Bad{"X", 0, "did you mean 'x'?"},
                    Bad{"2*Pi", 2, "did you mean 'pi'?"}, Bad{"sin(", 4, "ends too early"},
                    Bad{"(x", 2, "')' is missing"}, Bad{"x)", 1, "parenthesis ')'"},
                    Bad{"2 x", 2, "operator is missing before 'x'"}, Bad{"x 2", 2, "operator is missing before '2'"},
                    Bad{"0.1 < t < 0.2 ? 3 : 0", 8, "'a < b < c' is written 'a < b && b < c'"},
                    Bad{"x == y == z", 7, "the result of a comparison"},
                    Bad{"2*exp", 2, "function 'exp' needs its arguments"},
                    Bad{"x < 0 and y > 0", 6, "'and' is written '&&'"},
                    Bad{"x sin(t)", 2, "operator is missing before 'sin'"}, Bad{"x +", 3, "ends too early"},
                    Bad{"sin(1,2)", 7, "too many arguments"}, Bad{"atan2(1)", 7, "needs more arguments"},
                    Bad{"x;y", 1, "not known"}, Bad{"#", 0, "not known"}, Bad{"\"a\"", 3, "no quotes"},
                    Bad{"-", 1, "ends too early"}, Bad{"1,5 kPa", 4, "a decimal point is written '.'"},
                    Bad{"system(1)", 0, "'system' is not a function"}, Bad{"1e999", 0, "not known"}));

TEST(Expression, LongAndDeepFormulasDoNotCrash) {
  EXPECT_THROW(Expression(std::string(100000, '(')), ExpressionError);
  EXPECT_THROW(Expression(std::string(100000, 'x')), ExpressionError);
  const std::string deep = std::string(1000, '(') + "x" + std::string(1000, ')');
  EXPECT_EQ(Expression(deep)(2, 0, 0, 0), 2);
  std::string sum = "x";
  for (int i = 0; i < 5000; ++i) sum += "+x";
  try {
    EXPECT_EQ(Expression(sum)(1, 0, 0, 0), 5001);
  } catch (const ExpressionError& error) {
    EXPECT_STREQ(error.what(), "the formula is too long");
  }
}

}  // namespace
}  // namespace pliant::test_expression
