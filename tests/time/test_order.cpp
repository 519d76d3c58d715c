// Orders measured on nonlinear motions, and what symplectic methods keep.
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/order.hpp"
#include "time/step_control.hpp"
#include "time/stepper.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_order {
namespace {

using test::end_time;
using test::equal;
using test::Errors;
using test::expect_order;
using test::Ode;
using test::pendulum;
using test::Times;
using test::uneven;

class MethodOrders : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, MethodOrders, test::every_method(), test::method_name);

enum class Start { exact, ramp };

Errors error_after(const Method& method, const Ode& ode, Start start, const Times& times, int num_steps) {
  History history = start == Start::exact ? test::history_of(ode, test::earlier_times(method, times, num_steps))
                                          : test::history_of(ode);
  Stepper stepper = test::make_stepper(method, ode);
  Errors errors;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = times(n, num_steps);
    const StepAttempt attempt = stepper.attempt(history, {t, t - history.newest().time});
    EXPECT_EQ(attempt.report.outcome, StageOutcome::converged);
    accept(attempt, history);
    if (test::is_sampled(n, num_steps)) errors.look(ode, history.newest());
  }
  return errors;
}

/// A mass driven through a spring and a dashpot by a neighbour that moves as u_D = A (1 - cos w t).
Ode driven_mass() {
  const double A = 0.7, w = 3.0;
  return {[](double, auto q, auto v, std::size_t k) {
            const double u = q[k] - q[k - 1];
            return -4.0 * u - 3.0 * u * u * u - 1.5 * (v[k] - v[k - 1]);
          },
          {{0.0, 0.2}, {0.0, -0.1}},
          [=](double t) {
            return std::array{A * (1 - std::cos(w * t)), A * w * std::sin(w * t), A * w * w * std::cos(w * t)};
          }};
}

TEST_P(MethodOrders, HasItsOrderAfterAnExactStart) {
  expect_order("pendulum " + GetParam().name, GetParam().order,
               [&](int n) { return error_after(GetParam(), pendulum(), Start::exact, equal, n); });
}

// The one backward-Euler step of the ramp leaves an error of dt^2 behind: nothing to bdf2, one order to bdf3.
TEST_P(MethodOrders, HasAtMostSecondOrderAfterARamp) {
  expect_order("ramp " + GetParam().name, GetParam().num_steps > 1 ? 2 : GetParam().order,
               [&](int n) { return error_after(GetParam(), pendulum(), Start::ramp, equal, n); });
}

TEST_P(MethodOrders, HasItsOrderAfterAStartByDirk33) {
  const Ode ode = pendulum();
  expect_order("dirk33 start " + GetParam().name, GetParam().order, [&](int n) {
    const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
    Integrator integrator({GetParam(), Startup::dirk33}, test::system_of(ode), {0.0, q.get(), v.get()});
    Errors errors;
    for (int step = 1; step <= n; ++step) {
      integrator.accept(integrator.attempt({equal(step, n), end_time / n}));
      if (test::is_sampled(step, n)) errors.look(ode, integrator.state());
    }
    return errors;
  });
}

TEST_P(MethodOrders, KeepsItsOrderWithChangingSteps) {
  expect_order("uneven " + GetParam().name, GetParam().order,
               [&](int n) { return error_after(GetParam(), pendulum(), Start::exact, uneven, n); });
}

TEST_P(MethodOrders, KeepsItsOrderWithPrescribedMotion) {
  expect_order("prescribed " + GetParam().name, GetParam().order,
               [&](int n) { return error_after(GetParam(), driven_mass(), Start::exact, equal, n); });
}

TEST_P(MethodOrders, KeepsItsOrderWithPrescribedMotionAndChangingSteps) {
  expect_order("prescribed uneven " + GetParam().name, GetParam().order,
               [&](int n) { return error_after(GetParam(), driven_mass(), Start::exact, uneven, n); });
}

// Two failures in a row half way: the step is cut to a quarter and grows back by doubling, which bdf3 bridges with
// bdf2.
TEST_P(MethodOrders, KeepsItsOrderAcrossARetry) {
  const Ode ode = pendulum();
  expect_order("retry " + GetParam().name, GetParam().order, [&](int n) {
    const double dt = end_time / n;
    History history = test::history_of(ode, test::earlier_times(GetParam(), equal, n));
    Stepper stepper = test::make_stepper(GetParam(), ode);
    Errors errors;
    for (StepControl control({0.0, dt, end_time, dt / 8}); !control.finished();) {
      if (control.progress().nominal == n / 2 && control.next().dt == dt) {
        control.reject("asked to");
        control.reject("asked to");
      }
      accept(stepper.attempt(history, control.next()), history);
      control.accept();
      const bool on_grid = control.progress().time == static_cast<double>(control.progress().nominal) * dt;
      if (on_grid && test::is_sampled(static_cast<int>(control.progress().nominal), n))
        errors.look(ode, history.newest());
    }
    return errors;
  });
}

// Completed values are the given ones to the last bit; the acceleration behind reaction forces is a_D at the last
// stage.
TEST_P(MethodOrders, GivesPrescribedEntriesTheirMotion) {
  const Ode ode = driven_mass();
  History history = test::history_of(ode);
  Stepper stepper = test::make_stepper(GetParam(), ode);
  for (int n = 1; n <= 5; ++n) {
    const StepAttempt attempt = stepper.attempt(history, {n * 0.1, 0.1});
    EXPECT_EQ(test::values_of(attempt.q)[0], ode.prescribed(n * 0.1)[0]);
    EXPECT_EQ(test::values_of(attempt.v)[0], ode.prescribed(n * 0.1)[1]);
    EXPECT_NEAR(test::values_of(attempt.last_a)[0], ode.prescribed(attempt.last_stage.time)[2], 1e-11);
    accept(attempt, history);
  }
}

/// Largest |E - E_0| / |E_0| in the first and in the last tenth of 1e5 steps.
std::array<double, 2> energy_errors(const Method& method, const Ode& ode, double dt,
                                    const std::function<double(double q, double v)>& energy) {
  constexpr int num_steps = 100000;
  History history = test::history_of(ode);
  Stepper stepper = test::make_stepper(method, ode);
  const double E_0 = energy(ode.initial.q[0], ode.initial.v[0]);
  std::array<double, 2> largest{};
  for (StepControl control({0.0, dt, num_steps * dt, dt}); !control.finished(); control.accept()) {
    accept(stepper.attempt(history, control.next()), history);
    const std::int64_t n = control.progress().nominal;
    if (n >= num_steps / 10 && n < num_steps - num_steps / 10) continue;
    const ConstArrayView q(history.newest().q.get()), v(history.newest().v.get());
    double& slot = largest[n < num_steps / 10 ? 0 : 1];
    slot = std::max(slot, std::abs(energy(q[0], v[0]) - E_0) / std::abs(E_0));
  }
  return largest;
}

TEST(SymplecticMethods, BoundTheEnergyOfALongMotion) {
  const Ode ode{[](double, auto q, auto, std::size_t k) { return -q[k] - q[k] * q[k] * q[k]; }, {{1.0}, {0.5}}, {}};
  const auto energy = [](double q, double v) { return 0.5 * v * v + 0.5 * q * q + 0.25 * q * q * q * q; };
  for (const Method& method : methods()) {
    if (!method.symplectic) continue;
    const auto [early, late] = energy_errors(method, ode, 0.1, energy);
    EXPECT_LT(early, 2e-3) << method.name;  // of the size of dt^2
    EXPECT_LT(late, 1.01 * early) << method.name;
  }
}

TEST(ImplicitMidpoint, KeepsTheEnergyOfALinearMotion) {
  const Ode ode{[](double, auto q, auto, std::size_t k) { return -q[k]; }, {{1.0}, {0.5}}, {}};
  const auto [early, late] =
      energy_errors(*find_method("implicit-midpoint"), ode, 0.3, [](double q, double v) { return v * v + q * q; });
  EXPECT_LT(std::max(early, late), 1e-10);  // rounding of 1e5 steps
}

}  // namespace
}  // namespace pliant::test_order
