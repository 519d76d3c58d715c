#include "time/step_control.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_step_control {
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

// Whatever fails: every nominal time is hit, up to how the compiler rounds a product and a sum (with FMA once), no step
// is longer than nominal or more than twice the last accepted one, and none is a sliver.
TEST(StepControl, KeepsItsPromisesUnderRandomFailures) {
  constexpr double rounding = 1e-14;  // three ulp of the end
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
      EXPECT_LE(step.time, target + rounding) << "a nominal time was passed";
      shortest = std::min(shortest, step.dt);
      if (fails(random)) {
        asked = std::min(asked, step.dt / 2);
        ASSERT_EQ(control.reject("random").retry, Retry::again);
      } else {
        control.accept();
        time = step.time;
        last = step.dt;
        if (time >= target - rounding) ++n;
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

TEST(StepControl, NamesTheVariableAsThePlanDoes) {
  StepControl control({0.0, 0.25, 1.0, 0.25, {}, {}, {"load factor", ""}});
  EXPECT_EQ(
      control.reject("no equilibrium").reason,
      "step of 0.25 from load factor = 0 failed: no equilibrium; half of it is below the smallest step allowed, 0.25");
}

// Events lie between nominal times, on one (to rounding), close to one, and too close to the end to be one.
TEST(StepControl, StepsAlongAPathAreAsLongAsAskedFor) {
  StepPlan plan{0.0, 0.1, std::numeric_limits<double>::infinity(), 0.1 / 4.0};
  plan.path = PathPlan{0.3};
  plan.variable = {"path length", ""};
  StepControl control(plan);
  EXPECT_EQ(control.next().dt, 0.1);
  control.accept_on_path(0.09, 2.0);  // it ended earlier than planned
  EXPECT_EQ(control.next().dt, 0.2);
  EXPECT_EQ(control.next().time, 0.09 + 0.2);
  control.accept_on_path(0.29, 2.0);
  EXPECT_EQ(control.next().dt, 0.3);
  const RetryDecision decision = control.reject("it bends");
  EXPECT_EQ(decision.retry, Retry::again);
  EXPECT_EQ(decision.reason, "step of 0.3 from path length = 0.29 failed: it bends; trying 0.15");
  control.accept_on_path(0.44, 0.25);
  EXPECT_EQ(control.next().dt, 0.15 / 4.0);
  control.accept_on_path(0.45, 0.25);
  EXPECT_EQ(control.next().dt, plan.min_dt);
  EXPECT_EQ(control.reject("it bends").retry, Retry::give_up);
  EXPECT_FALSE(control.finished());
  control.stop();
  EXPECT_TRUE(control.finished());
  // Whether it has ended under another plan is for others to say.
  EXPECT_FALSE(StepControl(plan, under_plan(plan, control.progress())).finished());
}

TEST(StepControl, NominalStepsEndAtEventsToo) {
  const StepPlan plan{0.0, 0.1, 1.0, 1e-3, {0.05, 0.3, 0.42, 0.7000001, 1.0 - 1e-12}};
  StepControl control(plan);
  std::vector<double> times, events;
  std::int64_t num_nominal = 0;
  while (!control.finished()) {
    control.accept();
    times.push_back(control.progress().time);
    if (control.at_event()) events.push_back(times.back());
    if (control.at_interval()) ++num_nominal;
  }
  EXPECT_EQ(times,
            (std::vector<double>{0.05, 0.1, 0.2, 0.3, 0.4, 0.42, 0.5, 6 * 0.1, 7 * 0.1, 0.7000001, 0.8, 0.9, 1.0}));
  EXPECT_EQ(events, (std::vector<double>{0.05, 0.3, 0.42, 0.7000001, 1.0}));
  EXPECT_EQ(num_nominal, 10);
}

TEST(StepControl, AnEventDoesNotShortenTheStepsAfterIt) {
  StepControl control({0.0, 1.0, 4.0, 1e-3, {1.01, 2.99}});
  std::vector<double> times;
  for (const Step& step : all_steps(control)) times.push_back(step.time);
  EXPECT_EQ(times, (std::vector<double>{1.0, 1.01, 2.0, 2.99, 3.0, 4.0}));
}

AdaptivePlan adaptive(int order, double max_dt, double interval = 0.0, double max_growth = 2.4) {
  return {max_dt, interval, max_growth, order};
}

/// err = C(t) dt^(p+1) of a step that ends at t.
using ErrorModel = std::function<double(double t)>;

struct AdaptiveRun {
  std::vector<Step> steps;  // accepted
  std::vector<double> starts, events, intervals;
  double error = 0.0;  // sum
  int num_rejected = 0, num_changes = 0;
};

AdaptiveRun run(StepControl control, int order, const ErrorModel& C) {
  AdaptiveRun result;
  double last = 0.0;
  while (!control.finished()) {
    const Step step = control.next();
    const double error = C(step.time) * std::pow(step.dt, order + 1);
    if (!control.accepts(error)) {
      ++result.num_rejected;
      EXPECT_EQ(control.reject_error(error).retry, Retry::again);
      EXPECT_LT(control.next().dt, step.dt);
      continue;
    }
    result.starts.push_back(control.progress().time);
    result.steps.push_back(step);
    control.accept(error);
    EXPECT_EQ(control.progress().time, step.time);
    result.error += error;
    result.num_changes += static_cast<int>(step.dt != last);
    last = step.dt;
    if (control.at_event()) result.events.push_back(step.time);
    if (control.at_interval()) result.intervals.push_back(step.time);
  }
  return result;
}

struct Course {
  std::string name;
  ErrorModel C;
};

std::vector<Course> courses() {
  return {{"even", [](double) { return 3.0; }},
          {"slow", [](double t) { return 3 * (1.2 + std::sin(t)); }},
          {"falling", [](double t) { return 100 * std::exp(-t); }},
          {"jump", [](double t) { return t < 5 ? 1.0 : 100.0; }},
          {"pulse", [](double t) { return 1 + 1000 * std::exp(-std::pow((t - 5) / 0.2, 2)); }}};
}

// Errors that depend on the step as they should add up to no more than the tolerance (here 1), and not to much less.
TEST(AdaptiveSteps, UseUpTheTolerance) {
  for (const int order : {1, 2, 3}) {
    for (const auto& [name, C] : courses()) {
      const double scale = std::pow(10.0, order - 1);  // about as many steps for each order
      const AdaptiveRun got = run(StepControl({0.0, 1e-3, 10.0, 1e-9, {}, adaptive(order, 1.0)}), order,
                                  [&](double t) { return scale * C(t); });
      EXPECT_LE(got.error, 1.0) << name << order;
      EXPECT_GE(got.error, 0.5) << name << order;
      EXPECT_EQ(got.steps.back().time, 10.0);
      EXPECT_LE(got.num_rejected, 15) << name << order;
      EXPECT_LE(got.num_changes, static_cast<int>(got.steps.size()) / 3 + 12)
          << name << order << ": " << got.steps.size();
    }
  }
}

TEST(AdaptiveSteps, StayEqualToTheLastBitWhereTheErrorDoes) {
  // A thousand times to be hit, and the same steps from each to the next.
  const double C = 30.0;
  const AdaptiveRun got =
      run(StepControl({0.0, 1e-3, 100.0, 1e-9, {}, adaptive(2, 1.0, 0.1)}), 2, [=](double) { return C; });
  EXPECT_EQ(got.intervals.size(), 1000u);
  EXPECT_LE(got.num_changes, 20);
  EXPECT_GT(got.steps.size(), 3000u);
  EXPECT_GT(got.error, 0.25) << "cut into whole steps";
}

TEST(AdaptiveSteps, HitEveryTargetToTheLastBit) {
  const std::vector<double> events{0.123, 1.5, 1.6 + 1e-9, 3.3333, 9.99};
  for (const int order : {1, 2, 3}) {
    for (const auto& [name, C] : courses()) {
      for (const double interval : {0.1, 0.3, 7.0}) {
        const double max_growth = order == 3 ? 1.5 : 2.4;
        const StepPlan plan{0.0, 0.01, 10.0, 1e-6, events, adaptive(order, 0.5, interval, max_growth)};
        const AdaptiveRun got = run(StepControl(plan), order, C);
        EXPECT_EQ(got.events, events);
        const auto num = static_cast<std::size_t>(std::ceil(10.0 / interval - 1e-6));
        ASSERT_EQ(got.intervals.size(), num);
        for (std::size_t k = 1; k < num; ++k) {
          EXPECT_NEAR(got.intervals[k - 1], static_cast<double>(k) * interval, 2e-9);  // one is an event
          if (k != 16 || interval != 0.1) {
            EXPECT_EQ(got.intervals[k - 1], static_cast<double>(k) * interval);
          }
        }
        EXPECT_EQ(got.intervals.back(), 10.0);
      }
    }
  }
}

TEST(AdaptiveSteps, KeepTheirBounds) {
  const std::vector<double> events{1.5, 3.3333};
  for (const double max_growth : {1.5, 2.4, std::numeric_limits<double>::infinity()}) {
    for (const auto& [name, C] : courses()) {
      const StepPlan plan{0.0, 0.01, 10.0, 1e-6, events, adaptive(2, 0.3, 0.25, max_growth)};
      const AdaptiveRun got = run(StepControl(plan), 2, C);
      for (std::size_t n = 0; n < got.steps.size(); ++n) {
        const Step& step = got.steps[n];
        EXPECT_NEAR(step.time - got.starts[n], step.dt, 1e-14);
        EXPECT_LE(step.dt, 0.3 * (1 + 1e-6));
        if (n == 0) continue;
        const bool after_event = std::ranges::count(events, got.starts[n]) > 0;
        if (!after_event) {
          EXPECT_LE(step.dt, max_growth * got.steps[n - 1].dt * (1 + 1e-6)) << name;
        }
      }
    }
  }
}

TEST(AdaptiveSteps, LeaveNoSliver) {
  // An interval a little longer than the wanted step, and one that many do not divide: two steps, or one, not a short
  // one.
  for (const double interval : {0.101, 0.109, 0.111, 0.19, 0.201, 0.5, 0.7}) {
    StepControl control({0.0, 0.1, 10.0, 1e-6, {}, adaptive(2, 1.0, interval)});
    for (int n = 0; !control.finished(); ++n) {
      const Step step = control.next();
      const double wanted = control.progress().limit;
      if (control.progress().nominal + 1 < control.num_nominal()) {
        EXPECT_GE(step.dt, 0.5 * wanted) << interval;
        EXPECT_LE(step.dt, 1.1 * wanted * (1 + 1e-12)) << interval;
      }
      const double allowed = n < 4 ? std::max(step.dt / 10.0, 0.01) : step.dt / 10.0;
      control.accept(0.8 * allowed * std::pow(step.dt / wanted, 2));  // no change is called for
      EXPECT_EQ(control.progress().limit, wanted);
    }
  }
}

// Where estimates are poor, or rounding is all that is left, a step may take a hundredth of what is unspent.
TEST(AdaptiveSteps, MayTakeAHundredthOfTheToleranceWhereTheyAreHard) {
  StepControl control({0.0, 1e-3, 10.0, 1e-9, {}, adaptive(2, 1e-3)});
  const double ordinary = 1e-4;  // dt / T
  double unspent = 1.0;
  for (int n = 0; n < 4; ++n) {
    EXPECT_TRUE(control.accepts(0.0099 * unspent));
    EXPECT_FALSE(control.accepts(0.0101 * unspent));
    control.accept(0.8 * 0.01 * unspent);
    unspent += ordinary - 0.8 * 0.01 * unspent;
  }
  EXPECT_FALSE(control.accepts(1.01 * ordinary));
  EXPECT_TRUE(control.accepts(0.99 * ordinary));
  // What falls as it should with the step is the method's error, and is cut to its share.
  EXPECT_EQ(control.reject_error(0.1).retry, Retry::again);
  const double cut = control.next().dt / 1e-3;
  EXPECT_FALSE(control.accepts(0.1 * std::pow(cut, 3)));
  // What does not is taken, and so are the steps whose past is on the other side.
  EXPECT_TRUE(control.accepts(0.0099 * unspent));
  EXPECT_FALSE(control.accepts(0.0101 * unspent));
  control.accept(0.009 * unspent);
  EXPECT_TRUE(control.accepts(0.009 * unspent));
}

// The error of a solver that stops early: c dt, so that its share of the run stays the same however short steps are.
TEST(AdaptiveSteps, GoOnWhereTheSolversToleranceIsAllThatIsLeft) {
  for (double power : {-1.0, 0.0, 1.0}) {
    StepControl control({0.0, 0.01, 1.0, 1e-8, {}, adaptive(2, 0.1)});
    double spent = 0.0;
    int num_steps = 0, num_tried = 0;
    while (!control.finished()) {
      ASSERT_LT(++num_tried, 2000) << power;
      const Step step = control.next();
      const double rest = (power > 0 ? 1.5 : 1e-4) * std::pow(step.dt / (power > 0 ? 1.0 : 0.01), power);
      const double error = 2e3 * std::pow(step.dt, 3) + (step.time > 0.3 ? rest : 0.0);
      if (!control.accepts(error)) {
        ASSERT_EQ(control.reject_error(error).retry, Retry::again) << power;
        continue;
      }
      EXPECT_EQ(control.concession(error), "");
      spent += error;
      ++num_steps;
      control.accept(error);
    }
    EXPECT_LT(num_steps, 500) << power;
    EXPECT_LT(spent, 2.0) << power;
    EXPECT_NEAR(control.progress().spent, spent, 1e-12);
  }
}

// Steps that cross 0.4 have an error that no length makes smaller.
TEST(AdaptiveSteps, PassAJumpAtTheSmallestStepAndSaySo) {
  StepControl control({0.0, 0.01, 1.0, 1e-8, {}, adaptive(2, 0.1)});
  std::vector<std::string> concessions;
  int num_tried = 0;
  while (!control.finished()) {
    ASSERT_LT(++num_tried, 1000);
    const Step step = control.next();
    const bool crosses = control.progress().time < 0.4 && step.time >= 0.4;
    const double error = 2e3 * std::pow(step.dt, 3) + (crosses ? 3.0 : 0.0);
    const std::string concession = control.concession(error);
    if (!control.accepts(error) && concession.empty()) {
      ASSERT_EQ(control.reject_error(error).retry, Retry::again);
      continue;
    }
    if (!concession.empty()) concessions.push_back(concession);
    control.accept(error);
    EXPECT_EQ(control.at_event(), crosses) << "the past says nothing about what follows";
  }
  ASSERT_EQ(concessions.size(), 1);
  EXPECT_NE(concessions[0].find("does not fall with the step"), std::string::npos) << concessions[0];
}

// What is fast, and over soon, need not be followed more closely than a ten-thousandth of the tolerance asks for.
TEST(AdaptiveSteps, AreAllowedALeastPartOfTheTolerance) {
  StepControl control({0.0, 1e-5, 10.0, 1e-9, {}, adaptive(2, 1e-5)});
  for (int n = 0; n < 4; ++n) control.accept(0.0);
  EXPECT_TRUE(control.accepts(0.99e-4));
  EXPECT_FALSE(control.accepts(1.01e-4));
}

// One step ends 0.001 after a target: the next one is as long as wanted, though a fixed ratio may delay that.
TEST(AdaptiveSteps, AShortStepToATargetShortensNoOther) {
  StepControl control({0.0, 0.1, 10.0, 1e-6, {}, adaptive(2, 1.0, 0.301, std::numeric_limits<double>::infinity())});
  const auto accept = [&] { control.accept(0.8 * control.next().dt / 10.0 * std::pow(control.next().dt / 0.1, 2)); };
  for (int n = 0; n < 3; ++n) accept();
  EXPECT_EQ(control.progress().time, 0.301);
  StepProgress near = control.progress();
  near.time = 0.602 - 0.001;
  StepControl from_there({0.0, 0.1, 10.0, 1e-6, {}, adaptive(2, 1.0, 0.301, std::numeric_limits<double>::infinity())},
                         near);
  EXPECT_NEAR(from_there.next().dt, 0.001, 1e-15);
  from_there.accept(0.0);
  EXPECT_EQ(from_there.progress().limit, near.limit);
  EXPECT_NEAR(from_there.next().dt, 0.301 / 3, 1e-15);
}

TEST(AdaptiveSteps, StartSmallAfterAnEvent) {
  StepControl control({0.0, 0.1, 10.0, 1e-6, {1.0}, adaptive(2, 0.1)});
  const auto accept = [&] { control.accept(0.5 * control.next().dt / 10.0 * std::pow(control.next().dt / 0.1, 2)); };
  while (!control.at_event()) accept();
  EXPECT_EQ(control.progress().time, 1.0);
  EXPECT_NEAR(control.next().dt, 0.01, 1e-3);
  double last = control.next().dt;
  for (int n = 0; n < 5; ++n) {
    accept();
    EXPECT_FALSE(control.at_event());
    EXPECT_GT(control.next().dt, n < 2 ? 1.9 * last : last);
    last = control.next().dt;
  }
  EXPECT_GT(last, 0.09);
}

TEST(AdaptiveSteps, DoNotGrowRightAfterARejection) {
  StepControl control({0.0, 0.1, 10.0, 1e-6, {}, adaptive(2, 1.0)});
  EXPECT_FALSE(control.accepts(0.011)) << "the share is 0.01";
  EXPECT_TRUE(control.accepts(0.0099));
  const RetryDecision decision = control.reject_error(0.04);
  EXPECT_EQ(decision.retry, Retry::again);
  const double shorter = control.next().dt;
  EXPECT_NEAR(shorter, 0.1 * std::sqrt(0.8 / 4.0), 1e-3);
  EXPECT_NE(decision.reason.find("step of 0.1 s from t = 0 s has 4 times the allowed error; trying 0.0447214 s"),
            std::string::npos)
      << decision.reason;
  control.accept(0.0);
  EXPECT_NEAR(control.next().dt, shorter, 1e-12);
  control.accept(0.0);
  EXPECT_NEAR(control.next().dt, 2 * shorter, 1e-3);
  // Nor after a failure of the solver, which halves the step.
  EXPECT_EQ(control.reject("no convergence").retry, Retry::again);
  EXPECT_NEAR(control.next().dt, shorter, 1e-3);
  const double half = control.next().dt;
  control.accept(0.0);
  EXPECT_NEAR(control.next().dt, half, 1e-12);
}

TEST(AdaptiveSteps, GiveUpAtTheSmallestStepAndSayWhy) {
  StepControl control({0.0, 0.1, 10.0, 0.01, {}, adaptive(2, 1.0)});
  int num_rejected = 0;
  RetryDecision decision;
  double last = control.next().dt;
  while ((decision = control.reject_error(std::nan(""))).retry == Retry::again) {
    ASSERT_LT(++num_rejected, 10);
    EXPECT_LT(control.next().dt, last);
    last = control.next().dt;
    EXPECT_FALSE(control.accepts(std::nan("")));
  }
  EXPECT_GE(last, 0.0099);
  EXPECT_NE(decision.reason.find("smallest step allowed is 0.01 s"), std::string::npos) << decision.reason;
  // A step a little longer than the smallest is not tried for ever.
  StepControl close({0.0, 0.0105, 0.0105, 0.01, {}, adaptive(2, 1.0)});
  EXPECT_EQ(close.reject_error(1e3).retry, Retry::again);
  EXPECT_LT(close.next().dt, 0.0105);
  const RetryDecision last_decision = close.reject_error(1e2);
  EXPECT_EQ(last_decision.retry, Retry::give_up);
  EXPECT_NE(last_decision.reason.find("allow a smaller time.adaptive.min_step"), std::string::npos)
      << last_decision.reason;
}

// Whatever happens, a run is repeated and continued to the last bit.
TEST(AdaptiveSteps, ContinueFromTheirProgress) {
  const StepPlan plan{0.0, 0.01, 5.0, 1e-9, {0.7, 2.1, 2.2}, adaptive(2, 0.5, 0.25)};
  StepControl control(plan);
  std::mt19937 random(3);
  std::bernoulli_distribution fails(0.2);
  std::lognormal_distribution noise(0.0, 0.7);
  while (!control.finished()) {
    StepControl resumed(plan, control.progress());
    const double C = 30 * noise(random);
    const bool failed = fails(random);
    for (StepControl* each : {&resumed, &control}) {
      const double error = C * std::pow(each->next().dt, 3);
      if (failed) {
        EXPECT_EQ(each->reject("random").retry, Retry::again);
      } else if (!each->accepts(error)) {
        EXPECT_EQ(each->reject_error(error).retry, Retry::again);
      } else {
        each->accept(error);
      }
    }
    EXPECT_EQ(resumed.progress().time, control.progress().time);
    EXPECT_EQ(resumed.progress().limit, control.progress().limit);
    EXPECT_EQ(resumed.at_event(), control.at_event());
    if (!control.finished()) {
      EXPECT_EQ(resumed.next().dt, control.next().dt);
    }
  }
  EXPECT_EQ(control.progress().time, 5.0);
}

}  // namespace
}  // namespace pliant::test_step_control
