#include "run/arc_advance.hpp"

#include "petsc/check.hpp"
#include "run/solver_setup.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Angles between a step and the tangents at its ends: the largest that is accepted, and the one aimed at [rad].
constexpr double largest_turn = 0.5, aimed_turn = 0.15;
/// Iterations aimed at.
constexpr double aimed_iterations = 5.0;
constexpr double most_growth = 2.0, least_growth = 0.25;

/// The load factor at its extreme within a step, from its values and slopes at both ends (a cubic).
std::optional<double> extreme_within(double from, const PathStep& step) {
  const double L = step.length, m0 = L * step.slope_at_start, m1 = L * step.slope_at_end;
  if (m0 * m1 >= 0.0) return std::nullopt;
  const double rise = step.load_factor - from;
  // lambda(x) = from + m0 x + c x^2 + d x^3, 0 <= x <= 1
  const double c = 3.0 * rise - 2.0 * m0 - m1, d = m0 + m1 - 2.0 * rise;
  const double root = std::sqrt(std::max(0.0, c * c - 3.0 * d * m0));
  const double q = -(c + std::copysign(root, c));
  double x = m0 / (m0 - m1);
  for (const double candidate : {m0 / q, q / (3.0 * d)}) {
    if (candidate >= 0.0 && candidate <= 1.0) x = candidate;
  }
  return from + x * (m0 + x * (c + x * d));
}

}  // namespace

ArcAdvance::ArcAdvance(const Config& config, Model& model, const StateView& initial)
    : description_(description_of_solver(config, model)),
      motion_(model.constraints().motion()),
      internal_(model.potential().internal_variables()),
      end_time_(config.time.end),
      max_load_(config.time.path->max_load),
      min_load_(config.time.path->min_load.value_or(-std::numeric_limits<double>::infinity())),
      keeps_tangent_(model.constraints().map() == nullptr || model.constraints().map()->is_linear()),
      solver_(with_user_options([&] {
        return std::make_unique<PathSolver>(model.equation(), newton_options(config), linear_kind(config, model),
                                            [this](double load_factor, Vec q) { return pose(load_factor, q); });
      })) {
  for (Handle<Vec>* v : {&state_, &earlier_, &q_, &start_, &zero_, &start_velocity_}) *v = make_vector(model.layout());
  check(VecCopy(initial.q, state_.get()));
  if (initial.z == nullptr) return;
  for (Handle<Vec>* z : {&state_z_, &z_}) check(VecDuplicate(initial.z, z->out()));
  check(VecCopy(initial.z, state_z_.get()));
}

StagePoint ArcAdvance::pose(double load_factor, Vec q) {
  stage_ = {.time = end_time_,
            .dt = 1.0,
            .q0 = start_.get(),
            .v0 = start_velocity_.get(),
            .load_factor = load_factor,
            .step_start = end_time_ - 1.0,
            .z0 = state_z_.get(),
            .accepted = state_.get(),
            .accepted_z = state_z_.get()};
  motion_.start_stage(stage_, q);
  // Time stands still: prescribed functions of time have no rate.
  check(VecCopy(state_.get(), start_.get()));
  check(VecSet(start_velocity_.get(), 0.0));
  return stage_;
}

StageReport ArcAdvance::prepare() {
  solver_->start(state_.get(), load_factor_);
  if (!has_earlier_) {
    StageReport report = solver_->settle();
    if (report.outcome != StageOutcome::converged) {
      report.reason = "there is no equilibrium without loads, from which the path could start: " + report.reason;
      return report;
    }
  }
  if (solver_->has_tangent()) return {};
  return solver_->aim(has_earlier_ ? earlier_.get() : nullptr, earlier_load_factor_);
}

StageReport ArcAdvance::find_step(double length) {
  StageReport report = prepare();
  if (report.outcome != StageOutcome::converged) return report;
  report = solver_->step(length);
  if (report.outcome != StageOutcome::converged) return report;
  const PathStep& found = solver_->found();
  if (found.turn > largest_turn) {
    report.outcome = StageOutcome::retry;
    report.reason = fmt::format("the path bends by {:.2g} rad within the step; at most {:g} rad are accepted",
                                found.turn, largest_turn);
    return report;
  }
  finding_.growth = std::clamp(std::min(std::sqrt(aimed_iterations / std::max(1, report.newton_iterations)),
                                        aimed_turn / std::max(found.turn, 1e-6)),
                               least_growth, most_growth);
  const double limit = found.load_factor > max_load_ ? max_load_ : found.load_factor < min_load_ ? min_load_ : NAN;
  if (!std::isnan(limit) && !is_beyond(load_factor_)) {
    const StageReport end = solver_->land(limit);
    report.newton_iterations += end.newton_iterations;
    report.linear_iterations += end.linear_iterations;
  }
  return report;
}

std::optional<CriticalPoint> ArcAdvance::critical_point(const PathStep& step) const {
  using enum CriticalPoint::Kind;
  if (const auto extreme = extreme_within(load_factor_, step)) {
    return CriticalPoint{step.slope_at_start > 0.0 ? maximum : minimum, *extreme};
  }
  const bool is_known = step.unstable_modes && unstable_before_ >= 0.0;
  if (!is_known || static_cast<double>(*step.unstable_modes) == unstable_before_) return std::nullopt;
  return CriticalPoint{bifurcation, step.load_factor};
}

StepAttempt ArcAdvance::attempt(const Step& step) {
  StepAttempt result;
  result.report = find_step(step.dt);
  result.time = step.time;
  result.load_factor = load_factor_;
  if (result.report.outcome != StageOutcome::converged) {
    solver_->give_up(q_.get());
    return result;
  }
  const PathStep& found = solver_->found();
  solver_->leave(q_.get());
  finding_.unstable_modes = found.unstable_modes;
  finding_.critical = critical_point(found);
  finding_.is_at_end = is_beyond(found.load_factor);
  result.time = length_ + found.length;
  result.load_factor = found.load_factor;
  result.last_stage = stage_;
  result.q = result.last_q = q_.get();
  result.v = result.last_a = zero_.get();
  if (!z_) return result;
  check(VecCopy(state_z_.get(), z_.get()));
  internal_.complete_step(state_z_.get(), q_.get(), z_.get());
  result.z = z_.get();
  return result;
}

void ArcAdvance::accept(const StepAttempt& attempt) {
  check(VecCopy(state_.get(), earlier_.get()));
  earlier_load_factor_ = std::exchange(load_factor_, attempt.load_factor);
  has_earlier_ = true;
  length_ = attempt.time;
  unstable_before_ = finding_.unstable_modes ? static_cast<double>(*finding_.unstable_modes) : -1.0;
  check(VecCopy(attempt.q, state_.get()));
  if (state_z_) check(VecCopy(attempt.z, state_z_.get()));
  solver_->accept(keeps_tangent_);
}

StateView ArcAdvance::state() const {
  return {length_, state_.get(), zero_.get(), state_z_.get(), {}, load_factor_};
}

void ArcAdvance::keep(Archive& archive) {
  archive.number("length", length_);
  archive.number("load_factor", load_factor_);
  archive.vector("q", Entries::nodes, state_.get());
  archive.number("has_earlier", has_earlier_);
  archive.number("earlier_load_factor", earlier_load_factor_);
  archive.vector("earlier_q", Entries::nodes, earlier_.get());
  archive.number("scale", solver_->scale());
  archive.number("unstable_modes", unstable_before_);
  if (state_z_) archive.vector("z", Entries::internal, state_z_.get());
  if (!archive.restores()) return;
  solver_->forget();
  finding_.is_at_end = is_beyond(load_factor_);
}

}  // namespace pliant
