/// Motions of small bodies to the last digits, and how far they are apart: orders in time are measured with them.
#pragma once

#include "energy/dense_newton.hpp"
#include "energy/solid.hpp"
#include "time/integrator.hpp"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test {

/// (q, v) at `end_time`, after `num_steps` steps from `start`, by dense_newton; multistep methods start up by dirk33.
inline std::array<std::vector<double>, 2> end_of_motion(IncrementalPotential& potential, const Method& method,
                                                        const StateView& start, double end_time, int num_steps) {
  System system{dense_newton(potential)};
  system.guess = Guess::extrapolated;
  if (start.z != nullptr) {
    system.internal = potential.internal_variables();
    system.internal.complete_step(nullptr, start.q, start.z);
  }
  Integrator integrator({method, Startup::dirk33}, system, start);
  for (int n = 1; n <= num_steps; ++n) {
    const double time = end_time * n / num_steps;
    const StepAttempt attempt = integrator.attempt({time, time - integrator.state().time});
    EXPECT_EQ(attempt.report.outcome, StageOutcome::converged);
    if (attempt.report.outcome != StageOutcome::converged) break;
    integrator.accept(attempt);
  }
  return {local_values(integrator.state().q.get()), local_values(integrator.state().v.get())};
}

/// Euclidean.
inline double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares);
}

}  // namespace pliant::test
