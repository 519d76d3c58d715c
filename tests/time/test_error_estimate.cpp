#include "time/error_estimate.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/order.hpp"

#include <cmath>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

namespace pliant {
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

double square(const std::vector<double>& x) {
  double local = 0.0;
  for (double x_k : x) local += x_k * x_k;
  return sum(MPI_COMM_WORLD, local);
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return a;
}

/// Estimated and true errors over a motion, q and v: root mean squares.
struct Comparison {
  std::array<double, 2> estimated{}, exact{}, mismatch{};

  void add(const std::array<std::vector<double>, 2>& estimate, const std::array<std::vector<double>, 2>& truth) {
    for (std::size_t m = 0; m < 2; ++m) {
      estimated[m] = std::hypot(estimated[m], std::sqrt(square(estimate[m])));
      exact[m] = std::hypot(exact[m], std::sqrt(square(truth[m])));
      mismatch[m] = std::hypot(mismatch[m], std::sqrt(square(minus(estimate[m], truth[m]))));
    }
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
  return comparison;
}

// The relative error of the estimate is of the size of dt: at most a tenth in 200 steps, and half of it in 400.
void expect_sharp(const Ode& ode, const Method& method, const test::Times& times) {
  constexpr int num_steps = 200;
  const int first = 2 * method.num_steps + method.order;  // the start-up is over, and all rates are known
  const Comparison coarse = compare(ode, method, times, num_steps, first);
  const Comparison fine = compare(ode, method, times, 2 * num_steps, first);
  for (std::size_t m = 0; m < 2; ++m) {
    EXPECT_LT(coarse.mismatch[m], 0.1 * coarse.exact[m]) << method.name << (m == 0 ? ", q" : ", v");
    const double better = (coarse.mismatch[m] / coarse.exact[m]) / (fine.mismatch[m] / fine.exact[m]);
    EXPECT_NEAR(better, 2.0, 0.5) << method.name << (m == 0 ? ", q" : ", v");
  }
}

TEST_P(ErrorEstimates, AreTheErrorThatAStepAdds) {
  if (!GetParam().stiffly_accurate) return;
  expect_sharp(pendulum(), GetParam(), test::equal);
}

TEST_P(ErrorEstimates, AreTheErrorThatAChangedStepAdds) {
  if (!GetParam().stiffly_accurate) return;
  expect_sharp(pendulum(), GetParam(), test::uneven);
}

}  // namespace
}  // namespace pliant
