#include "time/step_control.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace pliant {
namespace {

std::vector<Step> all_steps(StepControl control) {
  std::vector<Step> steps;
  while (!control.finished()) {
    steps.push_back(control.next());
    control.accept();
  }
  return steps;
}

TEST(StepControl, NominalTimesCarryNoAccumulatedRounding) {
  const auto steps = all_steps(StepControl({0.0, 0.1, 1000.0, 1e-3}));
  ASSERT_EQ(steps.size(), 10000u);
  for (std::size_t n = 0; n + 1 < steps.size(); ++n) {
    EXPECT_EQ(steps[n].time, static_cast<double>(n + 1) * 0.1);
    EXPECT_EQ(steps[n].dt, 0.1);
  }
  EXPECT_EQ(steps.back().time, 1000.0);
  EXPECT_EQ(steps.back().dt, 0.1);
}

TEST(StepControl, LastStepIsShortenedToTheEnd) {
  const auto steps = all_steps(StepControl({1.0, 0.3, 2.0, 1e-3}));
  ASSERT_EQ(steps.size(), 4u);
  EXPECT_EQ(steps[2].time, 1.0 + 3 * 0.3);
  EXPECT_EQ(steps[3].time, 2.0);
  EXPECT_NEAR(steps[3].dt, 0.1, 1e-15);
}

TEST(StepControl, LeavesNoSliverAtTheEnd) {
  for (double dt : {1.0 / 3.0, 0.1, 1e-3, 1.0 / 7.0, 0.7}) {
    for (double excess : {-1e-8, -1e-15, 0.0, 1e-15, 1e-8}) {
      const double end = 21 * dt * (1.0 + excess);
      const auto steps = all_steps(StepControl({0.0, dt, end, dt / 100}));
      ASSERT_EQ(steps.size(), 21u) << dt << " " << excess;
      EXPECT_EQ(steps.back().time, end);
      EXPECT_NEAR(steps.back().dt, dt, 1e-6 * dt);
    }
  }
}

TEST(StepControl, OneStepIfTheEndIsNearerThanAStep) {
  const auto steps = all_steps(StepControl({0.0, 1.0, 0.25, 0.1}));
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].time, 0.25);
  EXPECT_EQ(steps[0].dt, 0.25);
  EXPECT_TRUE(StepControl({0.0, 1.0, 0.0, 0.1}).finished());
}

TEST(StepControl, HalvesAfterAFailureAndDoublesBackToTheGrid) {
  StepControl control({0.0, 1.0, 4.0, 0.01});
  control.accept();
  EXPECT_EQ(control.reject("a").retry, Retry::again);
  EXPECT_EQ(control.reject("b").retry, Retry::again);
  EXPECT_EQ(control.next().time, 1.25);
  EXPECT_EQ(control.next().dt, 0.25);
  std::vector<double> times;
  for (const Step& step : all_steps(control)) times.push_back(step.time);
  EXPECT_EQ(times, (std::vector<double>{1.25, 1.625, 2.0, 2.5, 3.0, 4.0}));
}

TEST(StepControl, GivesUpBelowTheSmallestStepAndSaysWhy) {
  StepControl control({0.0, 1.0, 2.0, 0.25});
  EXPECT_EQ(control.reject("inverted element").retry, Retry::again);
  EXPECT_EQ(control.reject("inverted element").retry, Retry::again);
  const RetryDecision last = control.reject("inverted element");
  EXPECT_EQ(last.retry, Retry::give_up);
  EXPECT_EQ(
      last.reason,
      "step of 0.25 s from t = 0 s failed: inverted element; half of it is below the smallest step allowed, 0.25 s");
}

// Whatever fails: every nominal time is hit to the last bit, no step is longer than nominal or more than twice the last
// accepted one, and none is a sliver.
TEST(StepControl, KeepsItsPromisesUnderRandomFailures) {
  std::mt19937 random(7);
  for (double probability : {0.05, 0.3, 0.45}) {
    const StepPlan plan{0.5, 0.1, 20.53, 1e-12};
    StepControl control(plan);
    std::bernoulli_distribution fails(probability);
    double time = plan.origin, last = plan.dt, shortest = plan.dt, asked = plan.dt;
    std::int64_t n = 1;
    while (!control.finished()) {
      const Step step = control.next();
      EXPECT_GT(step.time, time);
      EXPECT_NEAR(step.time - time, step.dt, 1e-14);
      EXPECT_LE(step.dt, plan.dt * (1 + 1e-6));
      EXPECT_LE(step.dt, 2 * last * (1 + 1e-6));
      const double target = n == control.num_nominal() ? plan.end : plan.origin + static_cast<double>(n) * plan.dt;
      EXPECT_LE(step.time, target) << "a nominal time was passed";
      shortest = std::min(shortest, step.dt);
      if (fails(random)) {
        asked = std::min(asked, step.dt / 2);
        ASSERT_EQ(control.reject("random").retry, Retry::again);
      } else {
        control.accept();
        time = step.time;
        last = step.dt;
        if (time == target) ++n;
      }
    }
    EXPECT_EQ(time, plan.end);
    EXPECT_EQ(n, control.num_nominal() + 1);
    EXPECT_GE(shortest, std::min(asked, 0.03) * (1 - 1e-6)) << "shorter than failures (or the end) asked for";
  }
}

TEST(StepControl, ContinuesFromItsProgress) {
  const StepPlan plan{0.0, 0.1, 1.0, 1e-6};
  StepControl control(plan);
  control.accept();
  control.reject("x");
  control.reject("x");
  control.accept();
  const auto rest = all_steps(control);
  const auto resumed = all_steps(StepControl(plan, control.progress()));
  ASSERT_EQ(rest.size(), resumed.size());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    EXPECT_EQ(rest[i].time, resumed[i].time);
    EXPECT_EQ(rest[i].dt, resumed[i].dt);
  }
}

}  // namespace
}  // namespace pliant
