#include "time/step_control.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>

namespace pliant {
namespace {

constexpr double growth = 2.0;
constexpr double sliver = 1e-6;  // of a step: a step is made longer by so much rather than followed by one so short

std::string seconds(double t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g s", t);
  return text;
}

std::int64_t count_steps(const StepPlan& plan) {
  return std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil((plan.end - plan.origin) / plan.dt - sliver)));
}

}  // namespace

StepControl::StepControl(const StepPlan& plan) : StepControl(plan, {0, plan.origin, plan.dt}) {}

StepControl::StepControl(const StepPlan& plan, const StepProgress& progress)
    : plan_(plan), num_nominal_(count_steps(plan)), progress_(progress) {
  assert(plan.dt > 0.0 && plan.min_dt > 0.0 && progress.limit > 0.0);
}

double StepControl::nominal_time(std::int64_t n) const {
  return n == num_nominal_ ? plan_.end : plan_.origin + static_cast<double>(n) * plan_.dt;
}

Step StepControl::next() const {
  assert(!finished());
  const double target = nominal_time(progress_.nominal + 1);
  const double rest = target - progress_.time;
  const double rounding =
      8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(target), std::abs(plan_.origin));
  if (rest <= progress_.limit * (1.0 + sliver)) {
    return {target, std::abs(rest - plan_.dt) <= rounding ? plan_.dt : rest};
  }
  // A rest of less than two steps is shared evenly, lest the second be short.
  const double dt = rest < growth * progress_.limit ? 0.5 * rest : progress_.limit;
  return {progress_.time + dt, dt};
}

void StepControl::accept() {
  const Step step = next();
  if (step.time == nominal_time(progress_.nominal + 1)) ++progress_.nominal;
  progress_.time = step.time;
  progress_.limit = std::min(growth * step.dt, plan_.dt);
}

RetryDecision StepControl::reject(const std::string& reason) {
  const Step step = next();
  const double half = 0.5 * step.dt;
  const std::string failure =
      "step of " + seconds(step.dt) + " from t = " + seconds(progress_.time) + " failed: " + reason;
  if (half < plan_.min_dt) {
    return {Retry::give_up, failure + "; half of it is below the smallest step allowed, " + seconds(plan_.min_dt)};
  }
  progress_.limit = half;
  return {Retry::again, failure + "; trying " + seconds(half)};
}

}  // namespace pliant
