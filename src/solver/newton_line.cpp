#include "solver/newton_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// What a step loses to a wall, if the wall counts.
constexpr double much_shorter = 0.5;

}  // namespace

NewtonLine::NewtonLine(Objective& objective, LinearSystem& system, SNES snes, SolverStatistics& statistics)
    : objective_(objective),
      system_(system),
      snes_(snes),
      statistics_(statistics),
      d_(objective.equation().make_vector()),
      r_(objective.equation().make_vector()),
      correction_(objective.equation()) {}

LineStart NewtonLine::lay(Vec q, Vec r, Vec y, Vec trial, double value) {
  q_ = q;
  trial_ = trial;
  length_ = std::numeric_limits<double>::quiet_NaN();
  check(VecCopy(y, d_.get()));
  check(VecScale(d_.get(), -1.0));
  LineStart start;
  start.slope = dot(r, d_.get());
  start.residual = norm(r);
  start.residual_rounding = objective_.equation().rounding_floor(q);
  start.step = norm(d_.get());
  if (objective_.is_minimised()) {
    start.measure = value;
    check(VecWAXPY(trial, -1.0, objective_.start(), q));
    start.displacement = norm(trial);
  } else {
    start.measure = objective_.merit().of_residual(r);
  }
  start.first_length = first_length();
  start.is_at_wall =
      start.first_length < much_shorter &&
      inversion_margin * objective_.equation().max_step_to_wall(q, d_.get(), StageEquation::Walls::all) < much_shorter;
  return start;
}

void NewtonLine::take(Vec q, Vec r) {
  check(VecCopy(r_.get(), r));
  objective_.move(q, trial_);
}

double NewtonLine::first_length() {
  const double bound = inversion_margin * objective_.equation().max_step(q_, d_.get());
  if (bound < 1.0) ++statistics_.capped_steps;
  return std::min(1.0, bound);
}

void NewtonLine::go_to(double alpha) {
  if (alpha == length_) return;
  check(VecWAXPY(trial_, alpha, d_.get(), q_));
  length_ = alpha;
}

double NewtonLine::potential(double alpha) {
  go_to(alpha);
  return objective_.value(trial_);
}

SearchLine::Residual NewtonLine::residual(double alpha) {
  go_to(alpha);
  check(SNESComputeFunction(snes_, trial_, r_.get()));
  return {norm(r_.get()), dot(r_.get(), d_.get())};
}

// When any equilibrium is sought, the potential only shows where the body cannot be.
bool NewtonLine::is_admissible() {
  return objective_.aim() != Aim::any_equilibrium || std::isfinite(objective_.value(trial_));
}

double NewtonLine::merit_of_correction() {
  system_.solve(r_.get(), correction_.get());
  if (!system_.has_direction(r_.get())) return std::numeric_limits<double>::infinity();
  return objective_.merit().of_step(correction_.get());
}

double NewtonLine::merit_of_nonlinear_part(double alpha) {
  check(VecAXPY(correction_.get(), 1.0 - alpha, d_.get()));
  return objective_.merit().of_step(correction_.get());
}

}  // namespace pliant
