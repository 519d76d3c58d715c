#include "time/circle.hpp"
#include "time/error_estimate.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/order.hpp"

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test_error_estimate {
namespace {

using test::Ode;
using test::pendulum;
using test::Values;

class ErrorEstimates : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, ErrorEstimates, test::every_method(), test::method_name);

/// The motion from a state other than the one at t = 0.
Values continued(const Ode& ode, const State& from, double t) {
  Ode shifted = ode;
  shifted.initial = {test::values_of(from.q.get()), test::values_of(from.v.get())};
  shifted.acceleration = [&](double s, auto q, auto v, std::size_t k) {
    return ode.acceleration(from.time + s, q, v, k);
  };
  if (ode.prescribed) shifted.prescribed = [&](double s) { return ode.prescribed(from.time + s); };
  return test::reference(shifted, t - from.time);
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return a;
}

/// Estimated and true errors over a motion, of q and v: root sums of squares.
struct Comparison {
  std::array<double, 2> estimated{}, exact{}, mismatch{};

  void add(const std::array<std::vector<double>, 2>& estimate, const std::array<std::vector<double>, 2>& truth) {
    const auto add_to = [](double& total, const std::vector<double>& x) {
      for (double x_k : x) total = std::hypot(total, x_k);
    };
    for (std::size_t m = 0; m < 2; ++m) {
      add_to(estimated[m], estimate[m]);
      add_to(exact[m], truth[m]);
      add_to(mismatch[m], minus(estimate[m], truth[m]));
    }
  }
  /// Over all ranks.
  Comparison reduced() const {
    Comparison all = *this;
    for (auto* part : {&all.estimated, &all.exact, &all.mismatch}) {
      for (double& total : *part) total = std::sqrt(sum(MPI_COMM_WORLD, total * total));
    }
    return all;
  }
};

Integrator integrator_of(const Ode& ode, const Method& method, Startup startup = Startup::dirk33) {
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  return {{method, startup, ErrorEstimate::local}, test::system_of(ode), {0.0, q.get(), v.get()}};
}

/// Runs the steps; compares those from the `first` on.
Comparison compare(const Ode& ode, const Method& method, const test::Times& times, int num_steps, int first) {
  Integrator integrator = integrator_of(ode, method);
  Comparison comparison;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = times(n, num_steps);
    const StepAttempt attempt = integrator.attempt({t, t - integrator.state().time});
    if (n >= first) {
      EXPECT_EQ(attempt.estimate_order, method.order);
      const Values exact = continued(ode, integrator.state(), t);
      comparison.add({test::values_of(attempt.error_q), test::values_of(attempt.error_v)},
                     {minus(test::values_of(attempt.q), exact.q), minus(test::values_of(attempt.v), exact.v)});
    }
    integrator.accept(attempt);
  }
  return comparison.reduced();
}

// The relative error of the estimate is of the size of dt: at most a tenth in num_steps, and twice that in half of
// them.
void expect_sharp(const Method& method, int num_steps, const std::function<Comparison(int num_steps)>& comparison) {
  const Comparison coarse = comparison(num_steps / 2), fine = comparison(num_steps);
  for (std::size_t m = 0; m < 2; ++m) {
    const std::string what = method.name + (m == 0 ? ", q" : ", v");
    EXPECT_LT(fine.mismatch[m], 0.1 * fine.exact[m]) << what;
    EXPECT_NEAR((coarse.mismatch[m] / coarse.exact[m]) / (fine.mismatch[m] / fine.exact[m]), 2.0, 0.5) << what;
    testing::Test::RecordProperty(m == 0 ? "mismatch_q" : "mismatch_v",
                                  std::to_string(fine.mismatch[m] / fine.exact[m]));
  }
}

void expect_sharp(const Ode& ode, const Method& method, const test::Times& times) {
  const int first = 2 * method.num_steps + method.order;  // the start-up is over, and all rates are known
  expect_sharp(method, 400, [&](int num_steps) { return compare(ode, method, times, num_steps, first); });
}

TEST_P(ErrorEstimates, AreTheErrorThatAStepAdds) {
  if (!GetParam().stiffly_accurate) return;
  expect_sharp(pendulum(), GetParam(), test::equal);
}

TEST_P(ErrorEstimates, AreTheErrorThatAChangedStepAdds) {
  if (!GetParam().stiffly_accurate) return;
  expect_sharp(pendulum(), GetParam(), test::uneven);
}

/// A mass on a spring and a dashpot, whose other end moves as u_D = 0.7 (1 - cos 2 t).
Ode driven_mass() {
  return {[](double, auto q, auto v, std::size_t k) { return -3.0 * (q[k] - q[k - 1]) - 0.5 * (v[k] - v[k - 1]); },
          {{0.0, 0.2}, {0.0, -0.1}},
          [](double t) {
            return std::array{0.7 * (1 - std::cos(2 * t)), 1.4 * std::sin(2 * t), 2.8 * std::cos(2 * t)};
          }};
}

// Prescribed entries have no error; their estimate is of one order more.
TEST_P(ErrorEstimates, AreSharpWithPrescribedMotion) {
  if (!GetParam().stiffly_accurate) return;
  expect_sharp(driven_mass(), GetParam(), test::equal);
}

Comparison compare_on_circle(const Method& method, int num_steps) {
  const Ode ode = pendulum();
  const Handle<Vec> q = test::points_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  Integrator integrator({method, Startup::dirk33, ErrorEstimate::local},
                        {.solve = test::solve_on_circle(ode), .space = std::make_shared<test::Circle>()},
                        {0.0, q.get(), v.get()});
  const Handle<Vec> xi = test::vector_of(ode.initial.q);
  Comparison comparison;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = test::uneven(n, num_steps);
    const State& start = integrator.state();
    const StepAttempt attempt = integrator.attempt({t, t - start.time});
    if (n >= 2 * method.num_steps + method.order) {
      State from(start.view());
      std::vector<double> angles;
      const auto points = test::values_of(start.q.get());
      for (std::size_t k = 0; 2 * k < points.size(); ++k) angles.push_back(test::Circle::angle(points, k));
      from.q = test::vector_of(angles);
      const Values exact = continued(ode, from, t);
      const Handle<Vec> there = test::points_of(exact.q);
      test::Circle().difference(there.get(), attempt.q, xi.get());
      comparison.add({test::values_of(attempt.error_q), test::values_of(attempt.error_v)},
                     {test::values_of(xi.get()), minus(test::values_of(attempt.v), exact.v)});
    }
    integrator.accept(attempt);
  }
  return comparison.reduced();
}

// Coordinates of the circle around q_n change at another rate than the velocity, and less evenly: shorter steps.
TEST_P(ErrorEstimates, AreSharpInCoordinatesOfASpace) {
  if (!GetParam().stiffly_accurate) return;
  expect_sharp(GetParam(), 800, [](int num_steps) { return compare_on_circle(GetParam(), num_steps); });
}

/// Estimates and errors of the first step of the length dt, or of the `n`-th.
Comparison nth_step(const Method& method, Startup startup, double dt, int n, int* order) {
  const Ode ode = pendulum();
  Integrator integrator = integrator_of(ode, method, startup);
  for (int i = 1; i < n; ++i) integrator.accept(integrator.attempt({i * dt, dt}));
  const StepAttempt attempt = integrator.attempt({n * dt, dt});
  *order = attempt.estimate_order;
  const Values exact = continued(ode, integrator.state(), n * dt);
  Comparison comparison;
  comparison.add({test::values_of(attempt.error_q), test::values_of(attempt.error_v)},
                 {minus(test::values_of(attempt.q), exact.q), minus(test::values_of(attempt.v), exact.v)});
  return comparison.reduced();
}

// While rates are missing the estimate is of the order it tells and not much below the error. What the first step of
// the ramp leaves behind, dt^2, is still felt by the next ones, and so is it in the estimate.
TEST_P(ErrorEstimates, AreOfTheirOrderAndNotTooSmallAtTheStart) {
  const Method& method = GetParam();
  if (why_not_adaptive(method)) return;
  for (const Startup startup : {Startup::ramp, Startup::dirk33}) {
    for (int n = 1; n <= method.order + 1; ++n) {
      int order = 0;
      const Comparison coarse = nth_step(method, startup, 4e-3, n, &order);
      const Comparison fine = nth_step(method, startup, 2e-3, n, &order);
      if (n > method.order) {
        EXPECT_EQ(order, method.stiffly_accurate ? method.order : method.embedded_order + 1) << method.name;
      }
      for (std::size_t m = 0; m < 2; ++m) {
        const std::string what = method.name + (m == 0 ? ", q, step " : ", v, step ") + std::to_string(n) +
                                 (startup == Startup::ramp ? " of the ramp" : " from dirk33");
        const bool is_first_of_ramp =
            n == 1 && method.bt_embedded.empty() && (startup == Startup::ramp || method.num_steps == 1);
        if (is_first_of_ramp && m == 1) {
          EXPECT_LT(fine.estimated[1], 1e-14) << what << ": nothing is known";
          continue;
        }
        const bool is_in_ramp = startup == Startup::ramp && method.num_steps > 1;
        EXPECT_GE(std::log2(coarse.estimated[m] / fine.estimated[m]), (is_in_ramp ? 2 : order + 1) - 0.1) << what;
        EXPECT_GT(fine.estimated[m], 0.5 * fine.exact[m]) << what;
      }
    }
  }
}

// On y' = lambda y the difference is c (lambda dt)^(p^+1), up to the next power.
TEST_P(ErrorEstimates, EmbeddedDifferenceIsAsDerived) {
  const Method& method = GetParam();
  if (method.bt_embedded.empty()) return;
  const double z = -1e-3, mu = -2.0;
  const Ode ode{
      [=](double, auto q, auto v, std::size_t k) { return (z + mu) * v[k] - z * mu * q[k]; }, {{1, 1}, {z, z}}, {}};
  const History history = test::history_of(ode);
  Stepper stepper = test::make_stepper(method, ode);
  (void)stepper.attempt(history, {1.0, 1.0});
  const Handle<Vec> q = test::vector_of({0.0, 0.0}), v = test::vector_of({0.0, 0.0});
  stepper.embedded_difference(q.get(), v.get());
  const double expected = method.embedded_error * std::pow(z, method.embedded_order + 1);
  const double rounding = 1e-15;  // of q; an error of q is one of v as dt = 1
  EXPECT_NEAR(test::values_of(q.get())[0], expected, 0.01 * std::abs(expected) + rounding);
  EXPECT_NEAR(test::values_of(v.get())[0], z * expected, 0.01 * std::abs(z * expected) + rounding);
}

TEST(ErrorEstimate, IsNotThereUnlessItIsKnownOrAskedFor) {
  const Ode ode = pendulum();
  for (const Method& method : methods()) {
    Integrator integrator = integrator_of(ode, method);
    EXPECT_EQ(integrator.attempt({0.1, 0.1}).error_v == nullptr, why_not_adaptive(method).has_value()) << method.name;
    const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
    Integrator silent({method}, test::system_of(ode), {0.0, q.get(), v.get()});
    EXPECT_EQ(silent.attempt({0.1, 0.1}).error_q, nullptr);
  }
}

// |(3, 4, 3, 4, ...)|_rms = sqrt(12.5)
TEST(ErrorNorm, IsTheLargerShareOfWhatIsTolerated) {
  const Handle<Vec> zero = test::vector_of({0.0, 0.0}), y = test::vector_of({3.0, 4.0});
  const Handle<Vec> error_q = test::vector_of({3e-3, 4e-3}), error_v = test::vector_of({3e-2, 4e-2});
  const double size = std::sqrt(12.5);
  ErrorNorm norm({0.1, 0.2, 0.4}, {0.0, zero.get(), zero.get()});
  StepAttempt attempt;
  attempt.q = zero.get();
  attempt.v = zero.get();
  attempt.error_q = error_q.get();
  attempt.error_v = error_v.get();
  EXPECT_NEAR(norm(attempt), std::max(1e-3 * size / 0.2, 1e-2 * size / 0.4), 1e-15);
  attempt.v = y.get();  // counts in the attempt itself
  const double with_motion = std::max(1e-3 * size / 0.2, 1e-2 * size / (0.4 + 0.1 * size));
  EXPECT_NEAR(norm(attempt), with_motion, 1e-15);
  attempt.v = zero.get();
  EXPECT_NEAR(norm(attempt), 1e-2 * size / 0.4, 1e-15) << "an attempt that is not accepted is forgotten";
  attempt.v = y.get();
  norm.accept(attempt);
  attempt.v = zero.get();
  EXPECT_NEAR(norm(attempt), with_motion, 1e-15) << "the largest so far";
  attempt.error_v = zero.get();
  EXPECT_NEAR(norm(attempt), 1e-3 * size / 0.2, 1e-15);
  attempt.q = y.get();
  EXPECT_NEAR(norm(attempt), 1e-3 * size / (0.2 + 0.1 * size), 1e-15);
}

// A body at rest with relative tolerances alone: an error of nothing is no error, and not 0 / 0.
TEST(ErrorNorm, OfNothingIsNothing) {
  const Handle<Vec> zero = test::vector_of({0.0, 0.0});
  const ErrorNorm norm({1e-3, 0.0, 0.0}, {0.0, zero.get(), zero.get()});
  StepAttempt attempt;
  attempt.q = attempt.v = attempt.error_q = attempt.error_v = zero.get();
  EXPECT_EQ(norm(attempt), 0.0);
}

}  // namespace
}  // namespace pliant::test_error_estimate
