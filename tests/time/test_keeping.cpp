// What is kept of a motion continues it to the last bit.
#include "petsc/memory_archive.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"
#include "time/step_control.hpp"

#include <gtest/gtest.h>

namespace pliant::test_keeping {
namespace {

using test::MemoryArchive;
using test::pendulum;

using Numbers = std::vector<std::vector<double>>;

Numbers numbers_of(const State& state) {
  return {{state.time},
          test::values_of(state.q.get()),
          test::values_of(state.v.get()),
          test::values_of(state.z.get()),
          state.w};
}

/// z' = q - z, and w' = v^2 of this rank's first entry over all ranks.
System system_with_everything() {
  System system = test::system_of(pendulum(), Guess::predicted);
  system.internal.end_stage = [](const StagePoint& stage, Vec q, Vec z) {
    check(VecCopy(stage.z0, z));
    check(VecAXPBY(z, stage.dt / (1.0 + stage.dt), 1.0 / (1.0 + stage.dt), q));
  };
  system.quadratures.rates = [](const StagePoint&, Vec, Vec v, Vec, std::span<double> rates) {
    PetscScalar square = 0.0;
    check(VecDot(v, v, &square));
    rates[0] = square;
  };
  return system;
}

Integrator integrator_of(const IntegratorOptions& options) {
  const auto ode = pendulum();
  const Handle<Vec> q = test::vector_of(ode.initial.q), v = test::vector_of(ode.initial.v);
  const std::vector<double> w{0.5};
  return {options, system_with_everything(), {0.0, q.get(), v.get(), q.get(), w}};
}

/// Lengths change, so that every past state counts.
Step step_after(double time, int n) {
  const double dt = n % 3 == 2 ? 0.08 : 0.1;
  return {time + dt, dt};
}

class Keeping : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, Keeping, test::every_method(), test::method_name);

TEST_P(Keeping, AnIntegratorGoesOnToTheLastBit) {
  for (const Startup startup : {Startup::ramp, Startup::dirk33}) {
    const IntegratorOptions options{GetParam(), startup, ErrorEstimate::local};
    for (const int num_before : {0, 1, 2, 5}) {
      Integrator first = integrator_of(options), second = integrator_of(options);
      const auto advance = [](Integrator& integrator, int n) {
        const StepAttempt attempt = integrator.attempt(step_after(integrator.state().time, n));
        Numbers errors;
        if (attempt.error_q != nullptr) errors = {test::values_of(attempt.error_q), test::values_of(attempt.error_v)};
        integrator.accept(attempt);
        return errors;
      };
      for (int n = 0; n < num_before; ++n) advance(first, n);
      MemoryArchive archive;
      first.keep(archive);
      archive.turn_round();
      second.keep(archive);
      EXPECT_EQ(numbers_of(second.state()), numbers_of(first.state()));
      for (int n = num_before; n < num_before + 5; ++n) {
        EXPECT_EQ(advance(first, n), advance(second, n)) << "error of step " << n;
        EXPECT_EQ(numbers_of(second.state()), numbers_of(first.state())) << "step " << n;
      }
    }
  }
}

TEST(KeepingErrors, AnErrorNormRemembersTheLargestStates) {
  const auto ode = pendulum();
  const Handle<Vec> q = test::vector_of(ode.initial.q), small = test::vector_of({1e-9, 1e-9});
  const StateView start{0.0, small.get(), small.get()};
  const Tolerances tolerances{1e-3, 1e-12, 1e-12};
  ErrorNorm first(tolerances, start), second(tolerances, start);
  StepAttempt attempt;
  attempt.q = attempt.v = q.get();
  attempt.error_q = attempt.error_v = small.get();
  first.accept(attempt);
  attempt.q = attempt.v = small.get();
  EXPECT_NE(first(attempt), second(attempt));
  MemoryArchive archive;
  first.keep(archive);
  archive.turn_round();
  second.keep(archive);
  EXPECT_EQ(first(attempt), second(attempt));
}

/// Steps with failures, events and errors that change.
StepControl control_after(const StepPlan& plan, int num_steps) {
  StepControl control(plan);
  for (int n = 0; n < num_steps; ++n) {
    if (n % 4 == 1) control.reject("a reason");
    control.accept(1e-3 * (1 + n % 3));
  }
  return control;
}

std::vector<double> times_of(StepControl control) {
  std::vector<double> times;
  for (int n = 0; !control.finished(); ++n) {
    times.push_back(control.next().time);
    control.accept(1e-3 * (1 + n % 2));
  }
  return times;
}

TEST(KeepingSteps, StepsGoOnAsPlanned) {
  const StepPlan nominal{0.0, 0.1, 2.05, 1e-4, {0.33}};
  StepPlan adaptive = nominal;
  adaptive.adaptive = AdaptivePlan{0.2, 0.25, 2.0, 2};
  for (const StepPlan& plan : {nominal, adaptive}) {
    for (const int num_steps : {0, 2, 5, 9}) {
      StepControl control = control_after(plan, num_steps);
      StepProgress kept = control.progress(), restored;
      MemoryArchive archive;
      kept.keep(archive);
      archive.turn_round();
      restored.keep(archive);
      EXPECT_EQ(times_of(StepControl(plan, under_plan(plan, restored))), times_of(control));
    }
  }
}

TEST(KeepingSteps, AFinishedRunIsFinished) {
  const StepPlan plan{0.0, 0.1, 0.25, 1e-4};
  StepControl control(plan);
  while (!control.finished()) control.accept();
  EXPECT_EQ(under_plan(plan, control.progress()).nominal, control.progress().nominal);
}

TEST(KeepingSteps, ALaterEndGoesBackToTheGridOfSteps) {
  StepPlan plan{0.0, 0.1, 0.25, 1e-4};
  StepControl control(plan);
  while (!control.finished()) control.accept();
  plan.end = 0.5;
  const auto times = times_of(StepControl(plan, under_plan(plan, control.progress())));
  EXPECT_EQ(times, (std::vector<double>{3 * 0.1, 4 * 0.1, 0.5}));
}

TEST(KeepingSteps, AnotherStepHasItsOwnGrid) {
  StepPlan plan{0.0, 0.1, 1.0, 1e-4};
  StepControl control(plan);
  for (int n = 0; n < 3; ++n) control.accept();
  plan.dt = 0.04;
  StepProgress progress = under_plan(plan, control.progress());
  progress.limit = plan.dt;
  const auto times = times_of(StepControl(plan, progress));
  EXPECT_EQ(times.front(), 8 * 0.04);
  EXPECT_EQ(times.back(), 1.0);
  EXPECT_EQ(times.size(), 18u);
}

}  // namespace
}  // namespace pliant::test_keeping
