// States with internal variables and quadratures, and configurations on a space with coordinates of its own.
#include "time/circle.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/order.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

namespace pliant::test_full_state {
namespace {

using test::end_time;
using test::Errors;
using test::Ode;

// A pendulum on the branch of a Maxwell material: with E(q) = q + q^2 / 2,
//     q'' = -1.2 sin q - 0.1 q' + 0.5 cos(1.3 t) - 0.8 (E - G) E'(q),   G' = (E - G) / tau,
// and two integrals along the motion, what the branch dissipates and a power in which a appears.
constexpr double tau = 0.4;

double strain(double q) {
  return q + 0.5 * q * q;
}

double acceleration(double t, double q, double v, double G) {
  return -1.2 * std::sin(q) - 0.1 * v + 0.5 * std::cos(1.3 * t) - 0.8 * (strain(q) - G) * (1.0 + q);
}

using Numbers = std::array<double, 2>;

/// dw/dt of one entry.
Numbers rates(double q, double v, double a, double G) {
  return {0.8 * (strain(q) - G) * (strain(q) - G) / tau, v * a};
}

/// (q, v, G, w) of one entry.
using Course = std::array<double, 5>;

Course slope(double t, const Course& y) {
  const double a = acceleration(t, y[0], y[1], y[2]);
  const Numbers k = rates(y[0], y[1], a, y[2]);
  return {y[1], a, (strain(y[0]) - y[2]) / tau, k[0], k[1]};
}

Course moved(const Course& y, double h, const Course& k) {
  Course result = y;
  for (std::size_t m = 0; m < y.size(); ++m) result[m] += h * k[m];
  return result;
}

/// By the classical Runge-Kutta method, to rounding.
Course exact(double t, Course y) {
  const int num_steps = 1 + static_cast<int>(std::abs(t) * 2000);
  const double h = t / num_steps;
  for (int n = 0; n < num_steps; ++n) {
    const Course k1 = slope(n * h, y), k2 = slope((n + 0.5) * h, moved(y, h / 2, k1));
    const Course k3 = slope((n + 0.5) * h, moved(y, h / 2, k2)), k4 = slope((n + 1) * h, moved(y, h, k3));
    for (std::size_t m = 0; m < y.size(); ++m) y[m] += h / 6 * (k1[m] + 2 * k2[m] + 2 * k3[m] + k4[m]);
  }
  return y;
}

/// Two entries on each rank.
State exact_state(double t) {
  std::vector<double> q, v, z;
  Numbers w{};
  for (int k = 0; k < 2; ++k) {
    const Course y = exact(t, {0.5 - 0.4 * k, 0.3 + 0.1 * rank(MPI_COMM_WORLD), 0.2, 0.0, 0.0});
    q.push_back(y[0]), v.push_back(y[1]), z.push_back(y[2]);
    for (std::size_t m = 0; m < w.size(); ++m) w[m] += y[3 + m];
  }
  for (double& w_m : w) w_m = sum(MPI_COMM_WORLD, w_m);
  const Handle<Vec> q_vec = test::vector_of(q), v_vec = test::vector_of(v), z_vec = test::vector_of(z);
  return State({t, q_vec.get(), v_vec.get(), z_vec.get(), w});
}

/// G_i of a stage, G_i = G_i0 + dt_i (E - G_i) / tau.
double relaxed(double G_0, double dt, double q) {
  return (G_0 + dt / tau * strain(q)) / (1.0 + dt / tau);
}

System maxwell_pendulum() {
  System system;
  system.guess = Guess::extrapolated;
  system.solve = [](const StagePoint& stage, Vec q) {
    const std::vector<double> z0 = test::values_of(stage.z0);
    return test::newton({[&](double t, auto at, auto v, std::size_t k) {
                           return acceleration(t, at[k], v[k], relaxed(z0[k], stage.dt, at[k]));
                         },
                         {z0, z0},
                         {}})(stage, q);
  };
  system.internal.end_stage = [](const StagePoint& stage, Vec q, Vec z) {
    const ConstArrayView z0(stage.z0), at(q);
    const ArrayView values(z);
    for (PetscInt k = 0; k < 2; ++k) values[k] = relaxed(z0[k], stage.dt, at[k]);
  };
  system.quadratures.rates = [](const StagePoint& stage, Vec q, Vec v, Vec a, std::span<double> k_w) {
    const ConstArrayView z0(stage.z0), at(q), rate(v), second(a);
    std::ranges::fill(k_w, 0.0);
    for (PetscInt k = 0; k < 2; ++k) {
      const Numbers local = rates(at[k], rate[k], second[k], relaxed(z0[k], stage.dt, at[k]));
      for (std::size_t m = 0; m < local.size(); ++m) k_w[m] += local[m];
    }
    for (double& k_m : k_w) k_m = sum(MPI_COMM_WORLD, k_m);
  };
  return system;
}

class FullStates : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, FullStates, test::every_method(), test::method_name);

Errors errors_of_full_state(const Method& method, const test::Times& times, int num_steps) {
  std::vector<double> past = test::earlier_times(method, times, num_steps);
  past.push_back(0.0);
  History history(method.num_steps, exact_state(past[0]).view());
  for (std::size_t r = 1; r < past.size(); ++r) history.push(exact_state(past[r]).view());
  Stepper stepper(method, maxwell_pendulum(), history.newest().view());
  Errors errors;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = times(n, num_steps);
    accept(stepper.attempt(history, {t, t - history.newest().time}), history);
    if (!test::is_sampled(n, num_steps)) continue;
    const State computed(history.newest().view()), expected = exact_state(t);
    errors.look("q", test::values_of(computed.q.get()), test::values_of(expected.q.get()));
    errors.look("v", test::values_of(computed.v.get()), test::values_of(expected.v.get()));
    errors.look("z", test::values_of(computed.z.get()), test::values_of(expected.z.get()));
    errors.look("w1", {computed.w[0]}, {expected.w[0]});
    errors.look("w2", {computed.w[1]}, {expected.w[1]});
  }
  return errors;
}

TEST_P(FullStates, AllPartsHaveTheOrderOfTheMethod) {
  test::expect_order("full state " + GetParam().name, GetParam().order,
                     [](int n) { return errors_of_full_state(GetParam(), test::equal, n); });
}

TEST_P(FullStates, AllPartsKeepTheOrderWithChangingSteps) {
  test::expect_order("full state, uneven, " + GetParam().name, GetParam().order,
                     [](int n) { return errors_of_full_state(GetParam(), test::uneven, n); });
}

// Internal variables that are functions of q are set to them at the end, and stand so in the history.
TEST_P(FullStates, CompletedStepsSetWhatIsAFunctionOfTheConfiguration) {
  System system = maxwell_pendulum();
  system.internal.complete_step = [](Vec /*accepted_z*/, Vec q, Vec z) {
    const ConstArrayView at(q);
    const ArrayView values(z);
    values[1] = strain(at[1]);
  };
  const State start = exact_state(0.0);
  Integrator plain({GetParam()}, maxwell_pendulum(), start.view()), set({GetParam()}, system, start.view());
  plain.accept(plain.attempt({0.1, 0.1}));
  set.accept(set.attempt({0.1, 0.1}));
  const auto q = test::values_of(set.state().q.get());
  const auto z = test::values_of(set.state().z.get()), formula = test::values_of(plain.state().z.get());
  EXPECT_EQ(z[0], formula[0]);
  EXPECT_EQ(z[1], strain(q[1]));
  EXPECT_NE(z[1], formula[1]);
}

Errors errors_on_circle(const Method& method, const test::Times& times, int num_steps) {
  const Ode ode = test::pendulum();
  const auto push = [&](double t, const std::function<void(const StateView&)>& to) {
    const test::Values y = t == 0.0 ? ode.initial : test::reference(ode, t);
    const Handle<Vec> q = test::points_of(y.q), v = test::vector_of(y.v);
    to({t, q.get(), v.get()});
  };
  std::vector<double> past = test::earlier_times(method, times, num_steps);
  past.push_back(0.0);
  std::optional<History> history;
  push(past[0], [&](const StateView& y) { history.emplace(method.num_steps, y); });
  for (std::size_t r = 1; r < past.size(); ++r) push(past[r], [&](const StateView& y) { history->push(y); });
  Stepper stepper(method, {.solve = test::solve_on_circle(ode), .space = std::make_shared<test::Circle>()},
                  history->newest().view());
  Errors errors;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = times(n, num_steps);
    accept(stepper.attempt(*history, {t, t - history->newest().time}), *history);
    if (!test::is_sampled(n, num_steps)) continue;
    const test::Values expected = test::reference(ode, t);
    const Handle<Vec> points = test::points_of(expected.q);
    errors.look("q", test::values_of(history->newest().q.get()), test::values_of(points.get()));
    errors.look("v", test::values_of(history->newest().v.get()), expected.v);
  }
  return errors;
}

TEST_P(FullStates, MethodsKeepTheirOrderInCoordinatesOfASpace) {
  test::expect_order("circle " + GetParam().name, GetParam().order,
                     [](int n) { return errors_on_circle(GetParam(), test::equal, n); });
}

TEST_P(FullStates, MethodsKeepTheirOrderInCoordinatesOfASpaceWithChangingSteps) {
  test::expect_order("circle, uneven, " + GetParam().name, GetParam().order,
                     [](int n) { return errors_on_circle(GetParam(), test::uneven, n); });
}

}  // namespace
}  // namespace pliant::test_full_state
