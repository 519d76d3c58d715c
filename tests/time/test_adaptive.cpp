// Method, estimate, norm and step control together: the error of a motion is near what was asked for.
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/step_control.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_adaptive {
namespace {

using test::Ode;
using test::Values;

class AdaptiveMotion : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, AdaptiveMotion, test::every_method(), test::method_name);

constexpr double jump_time = 1.0, end = 3.0;

/// The pendulum, on which a constant load acts from the jump on.
Ode struck_pendulum() {
  Ode ode = test::pendulum();
  ode.acceleration = [free = ode.acceleration](double t, auto q, auto v, std::size_t k) {
    return free(t, q, v, k) + (t > jump_time ? 2.0 : 0.0);
  };
  return ode;
}

/// Runge-Kutta's, which evaluates no stage across the jump.
Values exact_end() {
  const Ode free = test::pendulum();
  const Ode loaded{
      [&](double t, auto q, auto v, std::size_t k) { return free.acceleration(jump_time + t, q, v, k) + 2.0; },
      test::reference(free, jump_time),
      {}};
  return test::reference(loaded, end - jump_time);
}

struct Outcome {
  double error = 0.0;  // at the end, root mean square
  int num_steps = 0, num_rejected = 0;
};

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) squares += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum(MPI_COMM_WORLD, squares) / sum(MPI_COMM_WORLD, static_cast<double>(a.size())));
}

Outcome run(const Method& method, double tolerance) {
  const Ode ode = struck_pendulum();
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  const StateView initial{0.0, q.get(), v.get()};
  Integrator integrator({method, Startup::dirk33, ErrorEstimate::local}, test::system_of(ode), initial);
  ErrorNorm norm({0.0, tolerance, tolerance}, initial);
  StepControl control(StepPlan{.origin = 0.0,
                               .dt = 1e-3,
                               .end = end,
                               .min_dt = 1e-9,
                               .events = {jump_time},
                               .adaptive = AdaptivePlan{0.5, 0.0, method.max_growth, method.order}});
  Outcome outcome;
  while (!control.finished()) {
    const StepAttempt attempt = integrator.attempt(control.next());
    const double error = norm(attempt);
    if (!control.accepts(error)) {
      const RetryDecision decision = control.reject_error(error);
      if (decision.retry == Retry::give_up) {
        ADD_FAILURE() << decision.reason;
        return outcome;
      }
      ++outcome.num_rejected;
      continue;
    }
    control.accept(error);
    norm.accept(attempt);
    integrator.accept(attempt);
    if (control.at_event()) integrator.restart();
    ++outcome.num_steps;
  }
  const Values expected = exact_end();
  outcome.error = std::max(rms_difference(test::values_of(integrator.state().q.get()), expected.q),
                           rms_difference(test::values_of(integrator.state().v.get()), expected.v));
  return outcome;
}

// The pendulum's damping outweighs what makes errors grow, so that what remains at the end is less than what the steps
// added, but not much. Without accelerations at the ends of steps the estimate is too large, and the error smaller.
TEST_P(AdaptiveMotion, HasAnErrorNearTheTolerance) {
  const Method& method = GetParam();
  if (why_not_adaptive(method)) return;
  for (const double part : {0.1, 0.02}) {
    const double tolerance = part * std::pow(10.0, -method.order);
    const Outcome outcome = run(method, tolerance);
    EXPECT_LT(outcome.error, tolerance);
    EXPECT_GT(outcome.error, method.stiffly_accurate ? 0.2 * tolerance : 0.0);
    EXPECT_LT(outcome.num_rejected, 10 + outcome.num_steps / 10) << outcome.num_steps << " steps";
    RecordProperty("steps_" + std::to_string(part), outcome.num_steps);
  }
}

}  // namespace
}  // namespace pliant::test_adaptive
