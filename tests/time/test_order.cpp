// Orders measured on nonlinear motions, and what symplectic methods keep.
#include "time/every_method.hpp"
#include "time/ode.hpp"
#include "time/step_control.hpp"
#include "time/stepper.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using test::Ode;
using test::pendulum;
using test::Values;

class MethodOrders : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, MethodOrders, test::every_method(), test::method_name);

constexpr double end_time = 2.0;
constexpr double slope_tolerance = 0.1;
constexpr int num_coarse = 320;  // steps of the coarser of two levels
constexpr int num_samples = 5;   // times at which errors are taken, lest one that passes through zero mislead

enum class Start { exact, ramp };

/// Where the steps end that make up [0, end_time], and those before 0 for an exact start.
using Times = std::function<double(int step, int num_steps)>;

double equal(int step, int num_steps) {
  return end_time * step / num_steps;
}

/// Eight steps of different lengths over and over; the longest jump up is by 1.4.
double uneven(int step, int num_steps) {
  constexpr std::array<double, 8> length = {1.0, 1.4, 1.7, 1.2, 0.8, 0.5, 0.6, 0.8};
  double offset = 0.0;
  const int period = static_cast<int>(std::floor(step / 8.0));
  for (int i = 0; i < step - 8 * period; ++i) offset += length[static_cast<std::size_t>(i)];
  return end_time * (8.0 * period + offset) / num_steps;
}

/// Largest over entries, ranks and the times looked at.
struct Error {
  double q = 0.0, v = 0.0;

  void look(const Ode& ode, const State& state) {
    const Values exact = test::reference(ode, state.time);
    q = std::max(q, test::distance(test::values_of(state.q.get()), exact.q));
    v = std::max(v, test::distance(test::values_of(state.v.get()), exact.v));
  }
};

Error error_after(const Method& method, const Ode& ode, Start start, const Times& times, int num_steps) {
  std::vector<double> earlier;
  if (start == Start::exact) {
    for (int r = method.num_steps - 1; r >= 1; --r) earlier.push_back(times(-r, num_steps));
  }
  History history = test::history_of(ode, earlier);
  Stepper stepper = test::make_stepper(method, ode);
  Error error;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = times(n, num_steps);
    const StepAttempt attempt = stepper.attempt(history, {t, t - history.newest().time});
    EXPECT_EQ(attempt.report.outcome, StageOutcome::converged);
    accept(attempt, history);
    if (n % (num_steps / num_samples) == 0) error.look(ode, history.newest());
  }
  return error;
}

void expect_order(const std::string& what, double order, const std::function<Error(int num_steps)>& error) {
  const Error coarse = error(num_coarse), fine = error(2 * num_coarse);
  const double order_q = std::log2(coarse.q / fine.q), order_v = std::log2(coarse.v / fine.v);
  EXPECT_NEAR(order_q, order, slope_tolerance) << what << ", q: errors " << coarse.q << ", " << fine.q;
  EXPECT_NEAR(order_v, order, slope_tolerance) << what << ", v: errors " << coarse.v << ", " << fine.v;
  testing::Test::RecordProperty("order_q", std::to_string(order_q));
  testing::Test::RecordProperty("order_v", std::to_string(order_v));
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
    std::vector<double> earlier;
    for (int r = GetParam().num_steps - 1; r >= 1; --r) earlier.push_back(-r * dt);
    History history = test::history_of(ode, earlier);
    Stepper stepper = test::make_stepper(GetParam(), ode);
    Error error;
    for (StepControl control({0.0, dt, end_time, dt / 8}); !control.finished();) {
      if (control.progress().nominal == n / 2 && control.next().dt == dt) {
        control.reject("asked to");
        control.reject("asked to");
      }
      accept(stepper.attempt(history, control.next()), history);
      control.accept();
      const bool on_grid = control.progress().time == static_cast<double>(control.progress().nominal) * dt;
      if (on_grid && control.progress().nominal % (n / num_samples) == 0) error.look(ode, history.newest());
    }
    return error;
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
}  // namespace pliant
