#include "time/every_method.hpp"
#include "time/ode.hpp"
#include "time/step_control.hpp"
#include "time/stepper.hpp"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

namespace pliant::test_stepper {
namespace {

using test::Ode;
using test::pendulum;
using test::Values;

class MethodSteps : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, MethodSteps, test::every_method(), test::method_name);

/// Nothing is prescribed, every owned entry starts from the same (q, v).
Ode same_everywhere(test::Acceleration acceleration, double q, double v) {
  return {std::move(acceleration), {{q, q}, {v, v}}, {}};
}

/// y' = lambda y, as the eigenvector (1, lambda) of q'' = (lambda + mu) v - lambda mu q.
Ode test_equation(double lambda) {
  const double mu = -1.0;
  return same_everywhere(
      [=](double, auto q, auto v, std::size_t k) { return (lambda + mu) * v[k] - lambda * mu * q[k]; }, 1.0, lambda);
}

/// The stability function of an SDIRK method that has the order of its table: P(z) / (1 - g z)^s, where P is the series
/// of exp(z) (1 - g z)^s cut after degree s, or s - 1 if the method is L-stable.
double stability_function(const Method& m, double z) {
  const int s = m.num_stages, degree = m.stability == Stability::l_stable ? s - 1 : s;
  const double g = m.A[0][0];
  std::vector<double> P(static_cast<std::size_t>(degree) + 1);
  for (int i = 0; i <= degree; ++i) {
    double binomial = 1.0;  // of s over j, times (-g)^j
    for (int j = 0; j <= std::min(i, s); ++j) {
      P[static_cast<std::size_t>(i)] += binomial / std::tgamma(i - j + 1.0);
      binomial *= -g * (s - j) / (j + 1);
    }
  }
  double value = 0.0;
  for (int i = degree; i >= 0; --i) value = value * z + P[static_cast<std::size_t>(i)];
  return value / std::pow(1.0 - g * z, s);
}

TEST(OneStepMethods, MultiplyTheTestEquationByTheirStabilityFunction) {
  for (const Method& m : methods()) {
    if (m.num_steps > 1) continue;
    for (double z : {-0.1, -1.0, -7.0}) {
      const Ode ode = test_equation(z);
      History history = test::history_of(ode);
      Stepper stepper = test::make_stepper(m, ode);
      const StepAttempt attempt = stepper.attempt(history, {1.0, 1.0});
      ASSERT_EQ(attempt.report.outcome, StageOutcome::converged);
      EXPECT_NEAR(test::values_of(attempt.q)[0], stability_function(m, z), 1e-12) << m.name << ", z = " << z;
      EXPECT_NEAR(test::values_of(attempt.v)[0] / z, stability_function(m, z), 1e-12) << m.name << ", z = " << z;
    }
  }
}

// What the last stage is told of the end of its step, and each one of a symplectic method of the end of its midpoint
// rule, so that a constraint can be put there.
TEST_P(MethodSteps, EndsWhereTheLastStageIsTold) {
  const Ode ode = pendulum();
  const Values initial = ode.initial;
  History history(3, {-0.2, test::vector_of(initial.q).get(), test::vector_of(initial.v).get()});
  for (double t : {-0.1, 0.0}) history.push({t, test::vector_of(initial.q).get(), test::vector_of(initial.v).get()});
  System system = test::system_of(ode);
  std::vector<double> told, weights;
  system.solve = [&, solve = system.solve](const StagePoint& stage, Vec q) {
    StageReport report = solve(stage, q);
    weights.push_back(stage.end_weight);
    told = test::values_of(q);
    for (std::size_t k = 0; k < told.size(); ++k) {
      told[k] *= stage.end_weight;
      if (stage.end_rest != nullptr) told[k] += test::values_of(stage.end_rest)[k];
    }
    return report;
  };
  const Handle<Vec> layout = test::vector_of(initial.q);
  Stepper stepper(GetParam(), system, {0.0, layout.get(), layout.get()});
  const StepAttempt attempt = stepper.attempt(history, {0.1, 0.1});
  ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
  ASSERT_EQ(weights.size(), GetParam().b.size());
  for (std::size_t i = 0; i + 1 < weights.size(); ++i) EXPECT_EQ(weights[i], GetParam().symplectic ? 2.0 : 0.0);
  const auto end = test::values_of(attempt.q);
  for (std::size_t k = 0; k < end.size(); ++k) EXPECT_NEAR(told[k], end[k], 1e-15);
  EXPECT_GT(std::abs(end[0] - initial.q[0]), 1e-4);
}

TEST_P(MethodSteps, MultipliesAStiffModeByRInfinity) {
  const Method& m = GetParam();
  const double z = -1e7;
  const Ode ode = test_equation(z);
  const Values initial = ode.initial;
  History history(3, {-2.0, test::vector_of(initial.q).get(), test::vector_of(initial.v).get()});
  for (double t : {-1.0, 0.0}) history.push({t, test::vector_of(initial.q).get(), test::vector_of(initial.v).get()});
  Stepper stepper = test::make_stepper(m, ode);
  const StepAttempt attempt = stepper.attempt(history, {1.0, 1.0});
  ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
  EXPECT_NEAR(test::values_of(attempt.q)[0], m.R_infinity, 20 / std::abs(z));  // R(z) - R(infinity) = O(1/z)
  EXPECT_NEAR(test::values_of(attempt.v)[0] / z, m.R_infinity, 20 / std::abs(z));
}

// Errors at T = 3 pi of q'' = -q, q = q' = 1 at the start, in 48, 96, ..., 768 steps, made with other implementations
// (multistep methods with their first steps exact).
TEST(Oscillator, ErrorsArePublishedOnes) {
  const std::map<std::string, std::vector<double>> published = {
      {"backward-euler", {8.504198e-1, 5.229155e-1, 2.918974e-1, 1.544392e-1, 7.946058e-2}},
      {"implicit-midpoint", {4.257422e-2, 1.068997e-2, 2.675394e-3, 6.690298e-4, 1.672688e-4}},
      {"dirk22", {2.071588e-2, 5.191188e-3, 1.298543e-3, 3.246818e-4, 8.117331e-5}},
      {"dirk23", {8.811398e-3, 1.124842e-3, 1.413102e-4, 1.768518e-5, 2.211306e-6}},
      {"dirk33", {2.584591e-3, 3.257595e-4, 4.080071e-5, 5.102555e-6, 6.378956e-7}},
      {"bdf2", {1.584253e-1, 4.168675e-2, 1.059331e-2, 2.664152e-3, 6.676747e-4}},
      {"bdf3", {2.391975e-2, 3.069963e-3, 3.889312e-4, 4.894246e-5, 6.138090e-6}},
  };
  const Ode ode = same_everywhere([](double, auto q, auto, std::size_t k) { return -q[k]; }, 1.0, 1.0);
  for (const auto& [name, errors] : published) {
    for (std::size_t level = 0; level < errors.size(); ++level) {
      const Method& m = *find_method(name);
      const double end = 3 * M_PI, dt = end / (48 << level);
      const auto exact = [](double t) {
        const double q = std::cos(t) + std::sin(t), v = std::cos(t) - std::sin(t);
        return Values{{q, q}, {v, v}};
      };
      const Values first = exact(0.0);
      History history(3, {0.0, test::vector_of(first.q).get(), test::vector_of(first.v).get()});
      for (int n = 1; n < m.num_steps; ++n) {
        const Values y = exact(n * dt);
        history.push({n * dt, test::vector_of(y.q).get(), test::vector_of(y.v).get()});
      }
      Stepper stepper = test::make_stepper(m, ode);
      const StepProgress started{m.num_steps - 1, (m.num_steps - 1) * dt, dt};
      for (StepControl control({0.0, dt, end, dt}, started); !control.finished(); control.accept()) {
        accept(stepper.attempt(history, control.next()), history);
      }
      const double q = test::values_of(history.newest().q.get())[0], v = test::values_of(history.newest().v.get())[0];
      const double error = std::hypot(q + 1.0, v + 1.0);
      // Five digits, or rounding over 768 steps.
      EXPECT_NEAR(error, errors[level], 5e-6 * errors[level] + 1e-12) << name << ", " << (48 << level) << " steps";
    }
  }
}

// Prothero and Robinson's equation u' = lambda (u - cos t) - sin t, u = cos t, is that of v here. Errors of u at T = 1
// made with other implementations in 10, 20, ... steps. Very stiff (lambda = -1e6), stiffly accurate methods have tiny
// errors of order 1, and dirk23 falls from order 3 to 2: that is the order reduction every one of them must show.
TEST(ProtheroRobinson, ErrorsArePublishedOnes) {
  struct Published {
    const char* method;
    double lambda;
    std::vector<double> errors;  // 0: not published
  };
  const std::vector<Published> published = {
      {"backward-euler", -1e6, {2.839e-8, 1.386e-8, 6.841e-9, 3.399e-9, 1.694e-9}},
      {"dirk22", -1e6, {2.172e-8, 0, 0, 0, 1.202e-9}},
      {"dirk23", -1e6, {4.174e-4, 1.126e-4, 2.820e-5, 7.042e-6, 1.759e-6}},
      {"dirk33", -1e6, {1.319e-8, 0, 0, 0, 7.107e-10}},
      {"backward-euler", -1.0, {2.444e-2, 1.244e-2, 6.278e-3, 3.154e-3}},
      {"dirk22", -1.0, {1.927e-4, 4.753e-5, 1.180e-5, 2.941e-6}},
      {"dirk23", -1.0, {4.100e-5, 5.392e-6, 6.920e-7, 8.768e-8}},
      {"dirk33", -1.0, {1.752e-5, 2.237e-6, 2.827e-7, 3.554e-8}},
  };
  for (const auto& [name, lambda, errors] : published) {
    const double l = lambda;
    const Ode ode = same_everywhere(
        [=](double t, auto, auto v, std::size_t k) { return l * (v[k] - std::cos(t)) - std::sin(t); }, 0.0, 1.0);
    for (std::size_t level = 0; level < errors.size(); ++level) {
      if (errors[level] == 0.0) continue;
      const double dt = 1.0 / (10 << level);
      History history = test::history_of(ode);
      Stepper stepper = test::make_stepper(*find_method(name), ode);
      for (StepControl control({0.0, dt, 1.0, dt}); !control.finished(); control.accept()) {
        accept(stepper.attempt(history, control.next()), history);
      }
      const double error = std::abs(test::values_of(history.newest().v.get())[0] - std::cos(1.0));
      EXPECT_NEAR(error, errors[level], 1e-3 * errors[level]) << name << ", lambda " << l << ", dt " << dt;
    }
  }
}

// The guess decides the work, not the result.
TEST_P(MethodSteps, StartsTheSolverWhereTheGuessSays) {
  const Ode ode = pendulum();
  std::array<std::vector<double>, 2> ends;
  for (const Guess guess : {Guess::start, Guess::extrapolated}) {
    History history = test::history_of(ode);
    int num_stages = 0;
    const StageSolve solve = [&, inner = test::newton(ode)](const StagePoint& stage, Vec q) {
      ++num_stages;
      const double q0 = test::values_of(stage.q0)[0], v0 = test::values_of(stage.v0)[0];
      const double expected = guess == Guess::start ? q0 : q0 + stage.dt * v0;
      EXPECT_NEAR(test::values_of(q)[0], expected, 1e-15);
      return inner(stage, q);
    };
    Stepper stepper(GetParam(), {.solve = solve, .guess = guess}, history.newest().view());
    const StepAttempt attempt = stepper.attempt(history, {0.1, 0.1});
    EXPECT_EQ(num_stages, GetParam().num_stages);
    EXPECT_GE(attempt.report.newton_iterations, num_stages);
    ends[static_cast<std::size_t>(guess)] = test::values_of(attempt.q);
  }
  EXPECT_LT(test::largest_distance(ends[0], ends[1]), 1e-14);
}

// On a motion whose velocity is a parabola of time the prediction from three states is exact.
TEST_P(MethodSteps, ThePredictionContinuesTheVelocity) {
  const auto q_at = [](double t) { return 1.0 + t - t * t + t * t * t / 3.0; };
  const auto v_at = [](double t) { return 1.0 - 2.0 * t + t * t; };
  const Ode ode = pendulum();
  const std::vector<double> times{0.05, 0.1, 0.25, 0.4, 0.5, 0.6};
  for (const std::size_t num_states : {2u, 3u, 6u}) {
    if (GetParam().needs_equal_steps) continue;
    History history(static_cast<int>(num_states), test::history_of(ode).newest().view());
    State state(history.newest().view());
    for (std::size_t k = times.size() - num_states; k < times.size(); ++k) {
      check(VecSet(state.q.get(), q_at(times[k])));
      check(VecSet(state.v.get(), v_at(times[k])));
      state.time = times[k];
      history.push(state.view());
    }
    const StageSolve solve = [&, inner = test::newton(ode)](const StagePoint& stage, Vec q) {
      const double q0 = test::values_of(stage.q0)[0];
      const double line = v_at(0.6) + (v_at(0.6) - v_at(0.5)) / 0.1 * (stage.time - 0.6);
      const double v = num_states == 2 ? line : v_at(stage.time);
      EXPECT_NEAR(test::values_of(q)[0], q0 + stage.dt * v, 1e-14);
      return inner(stage, q);
    };
    Stepper stepper(GetParam(), {.solve = solve, .guess = Guess::predicted}, history.newest().view());
    EXPECT_EQ(stepper.attempt(history, {0.7, 0.1}).report.outcome, StageOutcome::converged);
    // Where a step is much longer than those before, a polynomial says little.
    const StageSolve long_solve = [&, inner = test::newton(ode)](const StagePoint& stage, Vec q) {
      if (stage.time - 0.6 > 0.25) {
        const double q0 = test::values_of(stage.q0)[0], v0 = test::values_of(stage.v0)[0];
        EXPECT_NEAR(test::values_of(q)[0], q0 + stage.dt * v0, 1e-14);
      }
      return inner(stage, q);
    };
    Stepper leaps(GetParam(), {.solve = long_solve, .guess = Guess::predicted}, history.newest().view());
    EXPECT_EQ(leaps.attempt(history, {1.6, 1.0}).report.outcome, StageOutcome::converged);
  }
}

TEST_P(MethodSteps, AccelerationBalancesTheForceOfTheLastStage) {
  const Ode ode = pendulum();
  History history = test::history_of(ode);
  Stepper stepper = test::make_stepper(GetParam(), ode);
  const StepAttempt attempt = stepper.attempt(history, {0.1, 0.1});
  const auto q = test::values_of(attempt.last_q), q0 = test::values_of(attempt.last_stage.q0);
  std::vector<double> v(q.size());
  for (std::size_t k = 0; k < q.size(); ++k) v[k] = (q[k] - q0[k]) / attempt.last_stage.dt;
  const auto a = test::values_of(attempt.last_a);
  for (std::size_t k = 0; k < q.size(); ++k) {
    EXPECT_NEAR(a[k], ode.acceleration(attempt.last_stage.time, q, v, k), 1e-11);  // rounding of q over dt^2
  }
  if (GetParam().stiffly_accurate) {
    EXPECT_EQ(attempt.last_stage.time, 0.1);
    const StepAttempt before_event = stepper.attempt(history, {0.1, 0.1, true});
    EXPECT_EQ(before_event.last_stage.time, std::nextafter(0.1, 0.0));  // before what jumps there
  }
}

struct Course {
  std::vector<Step> steps;  // accepted
  std::vector<double> q, v;
};

/// Three time units of the pendulum; calls of the solver with the numbers given fail and leave rubbish.
Course run_with_failures(const Method& method, const std::vector<int>& failing_calls) {
  const Ode ode = pendulum();
  History history = test::history_of(ode);
  int call = 0;
  const StageSolve solve = [&, inner = test::newton(ode)](const StagePoint& stage, Vec q) {
    if (std::ranges::count(failing_calls, ++call) == 0) return inner(stage, q);
    check(VecSet(q, NAN));
    return StageReport{StageOutcome::retry, "asked to fail", 1, 1};
  };
  Stepper stepper(method, {.solve = solve, .guess = Guess::extrapolated}, history.newest().view());
  Course course;
  for (StepControl control({0.0, 0.25, 3.0, 1e-3}); !control.finished();) {
    const StepAttempt attempt = stepper.attempt(history, control.next());
    if (attempt.report.outcome == StageOutcome::converged) {
      course.steps.push_back(control.next());
      control.accept();
      accept(attempt, history);
    } else {
      EXPECT_EQ(attempt.report.reason, "asked to fail");
      EXPECT_EQ(control.reject(attempt.report.reason).retry, Retry::again);
    }
  }
  course.q = test::values_of(history.newest().q.get());
  course.v = test::values_of(history.newest().v.get());
  return course;
}

// A run with failures ends, to the last bit, where a run does that takes the same accepted steps and never fails.
TEST_P(MethodSteps, FailedAttemptsLeaveNoTrace) {
  const Course failing = run_with_failures(GetParam(), {1, 6, 7, 12, 13, 14, 20, 29});
  EXPECT_GT(failing.steps.size(), 12u);
  const Ode ode = pendulum();
  History history = test::history_of(ode);
  Stepper stepper = test::make_stepper(GetParam(), ode);
  for (const Step& step : failing.steps) accept(stepper.attempt(history, step), history);
  EXPECT_EQ(test::values_of(history.newest().q.get()), failing.q);
  EXPECT_EQ(test::values_of(history.newest().v.get()), failing.v);
  EXPECT_EQ(history.newest().time, 3.0);
  // and close to where a run without failures ends, so that the comparison is of motions and not of rubbish
  EXPECT_LT(test::largest_distance(run_with_failures(GetParam(), {}).q, failing.q), 0.3);
}

TEST_P(MethodSteps, HistoryIsUntouchedUntilAcceptance) {
  const Ode ode = pendulum();
  History history = test::history_of(ode, {-0.2, -0.1});
  std::vector<std::vector<double>> before;
  const auto contents = [&] {
    std::vector<std::vector<double>> all;
    for (int age = 0; age < history.size(); ++age) {
      all.push_back(test::values_of(history[age].q.get()));
      all.push_back(test::values_of(history[age].v.get()));
      all.push_back({history[age].time});
    }
    return all;
  };
  before = contents();
  Stepper stepper = test::make_stepper(GetParam(), ode);
  const StepAttempt first = stepper.attempt(history, {0.1, 0.1});
  EXPECT_EQ(contents(), before);
  const auto q = test::values_of(first.q);
  accept(stepper.attempt(history, {0.1, 0.1}), history);
  EXPECT_EQ(test::values_of(history.newest().q.get()), q) << "the same attempt twice is the same";
  EXPECT_EQ(history.size(), 3);
  EXPECT_EQ(test::values_of(history[1].q.get()), before[0]);
}

TEST(Stepper, ReportsAFatalStageAndStopsThere) {
  const Ode ode = pendulum();
  History history = test::history_of(ode);
  int call = 0;
  const StageSolve solve = [&, inner = test::newton(ode)](const StagePoint& stage, Vec q) {
    return ++call == 2 ? StageReport{StageOutcome::fatal, "no memory", 3, 4} : inner(stage, q);
  };
  Stepper stepper(*find_method("dirk33"), {.solve = solve}, history.newest().view());
  const StepAttempt attempt = stepper.attempt(history, {0.1, 0.1});
  EXPECT_EQ(attempt.report.outcome, StageOutcome::fatal);
  EXPECT_EQ(attempt.report.reason, "no memory");
  EXPECT_EQ(attempt.report.linear_iterations, 4);
  EXPECT_EQ(call, 2);
  EXPECT_EQ(attempt.q, nullptr);
}

// After its first step bdf3 is bdf2, before it backward-euler.
TEST(Stepper, RampsUpThroughTheLowerFormulas) {
  const Ode ode = pendulum();
  History ramped = test::history_of(ode), by_hand = test::history_of(ode);
  Stepper bdf3 = test::make_stepper(*find_method("bdf3"), ode);
  for (const char* name : {"backward-euler", "bdf2", "bdf3"}) {
    Stepper stepper = test::make_stepper(*find_method(name), ode);
    const Step step{by_hand.newest().time + 0.1, 0.1};
    accept(stepper.attempt(by_hand, step), by_hand);
    accept(bdf3.attempt(ramped, step), ramped);
    EXPECT_EQ(test::values_of(ramped.newest().q.get()), test::values_of(by_hand.newest().q.get())) << name;
  }
}

}  // namespace
}  // namespace pliant::test_stepper
