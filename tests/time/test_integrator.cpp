#include "time/every_method.hpp"
#include "time/formula.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/order.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_integrator {
namespace {

using test::end_time;
using test::Errors;
using test::Ode;
using test::pendulum;

Integrator integrator_of(const Ode& ode, const IntegratorOptions& options) {
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  return {options, test::system_of(ode), {0.0, q.get(), v.get()}};
}

using Numbers = std::vector<std::vector<double>>;

Numbers numbers_of(const State& state) {
  return {{state.time}, test::values_of(state.q.get()), test::values_of(state.v.get())};
}

class Integrators : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, Integrators, test::every_method(), test::method_name);

TEST_P(Integrators, StartByDirk33AsLongAsStatesAreMissing) {
  const Method& method = GetParam();
  const Ode ode = pendulum();
  Integrator integrator = integrator_of(ode, {method, Startup::dirk33});
  History by_hand = test::history_of(ode);
  Stepper dirk33 = test::make_stepper(*find_method("dirk33"), ode), stepper = test::make_stepper(method, ode);
  for (int n = 1; n <= 5; ++n) {
    const Step step{n * 0.1, 0.1};
    integrator.accept(integrator.attempt(step));
    accept((n < method.num_steps ? dirk33 : stepper).attempt(by_hand, step), by_hand);
    EXPECT_EQ(numbers_of(integrator.state()), numbers_of(by_hand.newest())) << "step " << n;
  }
}

// Nothing of what went before an event is left, neither in the steps nor in the estimates.
TEST_P(Integrators, RestartLikeNewOnes) {
  const Ode ode = pendulum();
  for (const Startup startup : {Startup::ramp, Startup::dirk33}) {
    const IntegratorOptions options{GetParam(), startup, ErrorEstimate::local};
    Integrator old = integrator_of(ode, options);
    for (int n = 1; n <= 5; ++n) old.accept(old.attempt({n * 0.1, 0.1}));
    old.restart();
    Integrator fresh(options, test::system_of(ode), old.state().view());
    for (int n = 6; n <= 10; ++n) {
      const Step step{n * 0.1, 0.1};
      const StepAttempt a = old.attempt(step), b = fresh.attempt(step);
      if (a.error_q != nullptr) {
        EXPECT_EQ(test::values_of(a.error_q), test::values_of(b.error_q)) << "step " << n;
        EXPECT_EQ(test::values_of(a.error_v), test::values_of(b.error_v)) << "step " << n;
        EXPECT_EQ(a.estimate_order, b.estimate_order);
      }
      old.accept(a);
      fresh.accept(b);
      EXPECT_EQ(numbers_of(old.state()), numbers_of(fresh.state())) << "step " << n;
    }
  }
}

// Attempts of other lengths in between, which converge but are not accepted, change neither states nor estimates.
TEST_P(Integrators, RejectedAttemptsLeaveNoTrace) {
  const Ode ode = pendulum();
  for (const Startup startup : {Startup::ramp, Startup::dirk33}) {
    const IntegratorOptions options{GetParam(), startup, ErrorEstimate::local};
    Integrator rejecting = integrator_of(ode, options), plain = integrator_of(ode, options);
    double t = 0.0;
    for (int n = 0; n < 12; ++n) {
      const double dt = n % 4 == 3 ? 0.07 : 0.1;
      t += dt;
      const Step step{t, dt};
      (void)rejecting.attempt({t + 0.2, dt + 0.2});
      (void)rejecting.attempt({t - 0.01, dt - 0.01});
      const StepAttempt a = rejecting.attempt(step), b = plain.attempt(step);
      if (a.error_q != nullptr) {
        EXPECT_EQ(test::values_of(a.error_q), test::values_of(b.error_q)) << "step " << n;
        EXPECT_EQ(test::values_of(a.error_v), test::values_of(b.error_v)) << "step " << n;
      }
      rejecting.accept(a);
      plain.accept(b);
      EXPECT_EQ(numbers_of(rejecting.state()), numbers_of(plain.state())) << "step " << n;
    }
  }
}

/// Orders of tables that nobody ships; those of order 4 are told as 3.
int true_order(const test::OwnMethod& own) {
  return own.what.find("order 4") != std::string::npos || own.what.find("four") != std::string::npos ? 4
                                                                                                     : own.method.order;
}

/// A quarter of long steps, then short ones of half the length: (n/4) 2 h + (3n/4) h = end.
double halved(int step, int num_steps) {
  const double h = end_time / (1.25 * num_steps);
  const int num_long = num_steps / 4;
  return step <= num_long ? 2 * h * step : h * (step + num_long);
}

Errors errors_of(const IntegratorOptions& options, const test::Times& times, int num_steps) {
  const Ode ode = pendulum();
  Integrator integrator = integrator_of(ode, options);
  Errors errors;
  for (int n = 1; n <= num_steps; ++n) {
    const double t = times(n, num_steps);
    integrator.accept(integrator.attempt({t, t - integrator.state().time}));
    if (test::is_sampled(n, num_steps)) errors.look(ode, integrator.state());
  }
  return errors;
}

TEST(OwnMethods, HaveTheirOrderAfterAStartByDirk33) {
  for (const auto& own : test::own_methods()) {
    test::expect_order(own.what, true_order(own), [&](int n) {
      return errors_of({own.method, Startup::dirk33}, test::equal, n);
    });
  }
}

// The start-up method bridges the change of the step.
TEST(OwnMethods, KeepTheirOrderWhereTheStepChanges) {
  for (const auto& own : test::own_methods()) {
    test::expect_order(own.what + ", halved", true_order(own), [&](int n) {
      return errors_of({own.method, Startup::dirk33}, halved, n);
    });
  }
}

// The ramp costs no more than what its one step of backward Euler leaves behind.
TEST(OwnMethods, HaveAtMostSecondOrderAfterARamp) {
  for (const auto& own : test::own_methods()) {
    const int order = own.method.num_steps > 1 ? std::min(2, own.method.order) : true_order(own);
    test::expect_order(own.what + ", ramp", order, [&](int n) {
      return errors_of({own.method, Startup::ramp}, test::equal, n);
    });
  }
}

// dirk33 solves three stages a step, the formula one.
TEST(OwnMethods, TakeTheirOwnStepsOnceEnoughAreEqual) {
  const Method bdf4 = test::own_methods().back().method;
  const Ode ode = pendulum();
  int num_solves = 0;
  System system = test::system_of(ode);
  system.solve = [&, inner = system.solve](const StagePoint& stage, Vec q) {
    ++num_solves;
    return inner(stage, q);
  };
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  Integrator integrator({bdf4, Startup::dirk33}, system, {0.0, q.get(), v.get()});
  std::vector<int> solves;
  double t = 0.0;
  for (double dt : {0.1, 0.1, 0.1, 0.1, 0.1, 0.05, 0.05, 0.05, 0.05, 0.05}) {
    num_solves = 0;
    integrator.accept(integrator.attempt({t += dt, dt}));
    solves.push_back(num_solves);
  }
  EXPECT_EQ(solves, (std::vector{3, 3, 3, 1, 1, 3, 3, 3, 1, 1}));
}

}  // namespace
}  // namespace pliant::test_integrator
