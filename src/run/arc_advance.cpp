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
/// As often a step that seems to have left its branch is halved: a limit point and a bifurcation may be one.
constexpr int most_doubtful_attempts = 3;

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
      states_(config.time.end, model, initial),
      max_load_(config.time.path->max_load),
      min_load_(config.time.path->min_load.value_or(-std::numeric_limits<double>::infinity())),
      keeps_tangent_(model.constraints().map() == nullptr || model.constraints().map()->is_linear()),
      solver_(with_user_options([&] {
        return std::make_unique<PathSolver>(
            model.equation(), newton_options(config, model), linear_kind(config, model),
            [this](double load_factor, Vec q) { return states_.begin_stage(load_factor, q); });
      })) {
  check(VecDuplicate(initial.q, settled_.out()));
}

StageReport ArcAdvance::prepare() {
  solver_->start(states_.last(), states_.load_factor());
  if (!has_earlier_) {
    StageReport report = solver_->settle();
    if (report.outcome != StageOutcome::converged) {
      report.reason = "no equilibrium without loads was found, from which the path could start: " + report.reason;
      return report;
    }
    solver_->place(settled_.get());
  }
  if (solver_->has_tangent()) return {};
  return solver_->aim(has_earlier_ ? states_.earlier() : nullptr, states_.earlier_load_factor());
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
  if (is_doubtful(found) && ++doubtful_attempts_ <= most_doubtful_attempts) {
    report.outcome = StageOutcome::retry;
    report.reason =
        "the load turns, but the number of unstable modes does not change as at a limit point: the step has "
        "left its branch of the path, or passes several critical points";
    return report;
  }
  finding_.growth = std::clamp(std::min(std::sqrt(aimed_iterations / std::max(1, report.newton_iterations)),
                                        aimed_turn / std::max(found.turn, 1e-6)),
                               least_growth, most_growth);
  const double limit = found.load_factor > max_load_ ? max_load_ : found.load_factor < min_load_ ? min_load_ : NAN;
  if (!std::isnan(limit) && !is_beyond(states_.load_factor())) {
    const StageReport end = solver_->land(limit);
    report.newton_iterations += end.newton_iterations;
    report.linear_iterations += end.linear_iterations;
  }
  return report;
}

bool ArcAdvance::is_doubtful(const PathStep& step) const {
  const bool turns = step.slope_at_start * step.slope_at_end < 0.0;
  return turns && step.unstable_modes && unstable_before_ && (*step.unstable_modes - *unstable_before_) % 2 == 0;
}

std::optional<CriticalPoint> ArcAdvance::critical_point(const PathStep& step) const {
  using enum CriticalPoint::Kind;
  if (const auto extreme = extreme_within(states_.load_factor(), step)) {
    return CriticalPoint{step.slope_at_start > 0.0 ? maximum : minimum, *extreme};
  }
  const bool is_known = step.unstable_modes && unstable_before_;
  if (!is_known || *step.unstable_modes == *unstable_before_) return std::nullopt;
  return CriticalPoint{bifurcation, step.load_factor};
}

StepAttempt ArcAdvance::attempt(const Step& step) {
  const StageReport report = find_step(step.dt);
  if (report.outcome != StageOutcome::converged) {
    solver_->give_up(states_.unknown());
    StepAttempt failed;
    failed.report = report;
    failed.time = step.time;
    failed.load_factor = states_.load_factor();
    return failed;
  }
  const PathStep& found = solver_->found();
  solver_->leave(states_.unknown());
  finding_.unstable_modes = found.unstable_modes;
  finding_.critical = critical_point(found);
  finding_.is_at_end = is_beyond(found.load_factor);
  StepAttempt result = states_.end_step(length_ + found.length);
  result.report = report;
  result.load_factor = found.load_factor;
  return result;
}

void ArcAdvance::accept(const StepAttempt& attempt) {
  states_.accept(attempt);
  if (!has_earlier_) check(VecCopy(settled_.get(), states_.earlier()));
  has_earlier_ = true;
  doubtful_attempts_ = 0;
  length_ = attempt.time;
  unstable_before_ = finding_.unstable_modes;
  solver_->accept(keeps_tangent_);
}

void ArcAdvance::keep(Archive& archive) {
  double unstable_modes = unstable_before_ ? static_cast<double>(*unstable_before_) : -1.0;  // negative: not known
  states_.keep(archive);
  archive.number("length", length_);
  archive.number("has_earlier", has_earlier_);
  archive.number("scale", solver_->scale());
  archive.number("unstable_modes", unstable_modes);
  if (!archive.restores()) return;
  unstable_before_ =
      unstable_modes < 0.0 ? std::nullopt : std::optional<PetscInt>(static_cast<PetscInt>(unstable_modes));
  solver_->forget();
  finding_.is_at_end = is_beyond(states_.load_factor());
}

}  // namespace pliant
