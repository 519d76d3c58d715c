#include "base/time_integral.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_time_integral {
namespace {

struct Case {
  std::string rate;
  std::function<double(double)> integral;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"3", [](double t) { return 3.0 * t; }},
      {"2 + t^2", [](double t) { return 2.0 * t + t * t * t / 3.0; }},
      {"cos(20*t)", [](double t) { return std::sin(20.0 * t) / 20.0; }},
      {"exp(-t)", [](double t) { return 1.0 - std::exp(-t); }},
      {"min(t, 0.234)", [](double t) { return t < 0.234 ? 0.5 * t * t : 0.234 * (t - 0.117); }},
      {"t < pi/10 ? 5 : 1", [](double t) { return 5.0 * t - 4.0 * std::max(0.0, t - std::numbers::pi / 10.0); }}};
  return all;
}

TEST(TimeIntegral, IsTheAntiderivativeWhateverThePanels) {
  for (const auto& [rate, exact] : cases()) {
    for (const double panel : {0.01, 0.3, 5.0}) {
      const TimeIntegral integral(Expression(rate), 1.0, panel);
      for (const double t : {0.0, 1e-7, 0.01, 0.29999, 0.7, 1.0, 1.5}) {  // beyond the end, too
        EXPECT_NEAR(integral(t), exact(t), 1e-11) << rate << " at " << t << ", panels of " << panel;
      }
    }
  }
}

TEST(TimeIntegral, FindsPulsesAsLongAsAPanel) {
  const TimeIntegral integral(Expression("abs(t - 0.3333) < 0.005 ? 100 : 0"), 10.0, 0.01);
  EXPECT_NEAR(integral(10.0), 1.0, 1e-9);
}

TEST(TimeIntegral, OfNothingIsZero) {
  EXPECT_TRUE(TimeIntegral().is_zero());
  EXPECT_EQ(TimeIntegral()(3.0), 0.0);
  EXPECT_FALSE(TimeIntegral(Expression("t"), 1.0, 0.1).is_zero());
}

TEST(TimeIntegral, HasNoValueWhereTheRateHasNone) {
  EXPECT_FALSE(std::isfinite(TimeIntegral(Expression("1/t"), 1.0, 0.1)(0.5)));
}

}  // namespace
}  // namespace pliant::test_time_integral
