#include "time/step_control.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>

namespace pliant {
namespace {

constexpr double growth = 2.0;
constexpr int num_start_steps = 4;       // until estimates have their full order
constexpr int many_rejections = 3;       // in a row
constexpr double hard_step_part = 0.01;  // of the tolerance, for a step that is hard to estimate
constexpr double least_part = 1e-4;      // fraction of the tolerance, for any step
constexpr double reserve =
    1.0;  // fraction of the tolerance, for hard steps, in addition to what others leave of their shares
constexpr double missing_order = 0.7;  // an error that falls by so many powers less than it should is hard
constexpr double standstill = 0.5;  // the power of the step with which a jump's error, or the solver's, falls at most
constexpr double sliver = 1e-6;     // of a step: a step is made longer by so much rather than followed by one so short

// Adaptive steps:
constexpr double stretch = 0.1;  // a step may be so much longer than wanted if it spares a step
constexpr double strongest_cut = 0.2;
constexpr double after_event = 0.1;    // of the wanted step before the event
constexpr double aim = 0.8;            // the error aimed at, as a share of what is allowed
constexpr double largest_retry = 0.9;  // of a step whose error is too large
// The step stays as it is while the one aimed at is between 0.95 and 1.1 of it: the error is then 0.93 to 0.6 of what
// is allowed (third order; closer for lower).
constexpr double keep_from = 0.95, keep_to = 1.1;

/// Times are the same if they differ by no more.
double rounding_of(double a, double b) {
  return 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(a), std::abs(b));
}

/// Length between times that are hit; without an interval the whole run.
double spacing(const StepPlan& plan) {
  if (!plan.adaptive) return plan.dt;
  return plan.adaptive->interval > 0.0 ? plan.adaptive->interval : std::max(plan.end - plan.origin, plan.dt);
}

std::int64_t count_steps(const StepPlan& plan) {
  if (plan.path) return 1;  // the whole path
  const double num_steps = (plan.end - plan.origin) / spacing(plan);
  return std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(num_steps - sliver)));
}

}  // namespace

void StepProgress::keep(Archive& archive) {
  archive.number("nominal", nominal);
  archive.number("time", time);
  archive.number("limit", limit);
  archive.number("at_event", at_event);
  archive.number("at_interval", at_interval);
  archive.number("last_dt", last_dt);
  archive.number("error", error);
  archive.number("rejections", rejections);
  archive.number("rejected_dt", rejected_dt);
  archive.number("rejected_error", rejected_error);
  archive.number("wanted", wanted);
  archive.number("spent", spent);
  archive.number("num_after_start", num_after_start);
}

StepProgress under_plan(const StepPlan& plan, StepProgress progress) {
  if (plan.path) {
    progress.nominal = 0;  // whoever follows it knows whether it has ended
    progress.limit = std::min(progress.limit, plan.path->max_dt);
    return progress;
  }
  const bool is_over = progress.time >= plan.end - 0.5 * sliver * plan.dt;
  const auto completed = static_cast<std::int64_t>(std::floor((progress.time - plan.origin) / spacing(plan) + sliver));
  progress.nominal = is_over ? count_steps(plan) : completed;
  return progress;
}

StepControl::StepControl(const StepPlan& plan)
    : StepControl(
          plan, {0, plan.origin, plan.adaptive ? std::clamp(plan.dt, plan.min_dt, plan.adaptive->max_dt) : plan.dt}) {}

StepControl::StepControl(const StepPlan& plan, const StepProgress& progress)
    : plan_(plan), num_nominal_(count_steps(plan)), progress_(progress) {
  assert(plan.dt > 0.0 && plan.min_dt > 0.0 && progress.limit > 0.0);
  assert(std::ranges::is_sorted(plan.events));
  assert(!plan.adaptive || (plan.adaptive->max_dt >= plan.min_dt && plan.adaptive->order >= 1));
}

double StepControl::nominal_time(std::int64_t n) const {
  return n == num_nominal_ ? plan_.end : plan_.origin + static_cast<double>(n) * spacing(plan_);
}

StepControl::Target StepControl::target() const {
  const double nominal = nominal_time(progress_.nominal + 1), same = 0.5 * sliver * plan_.dt;
  const auto event = std::ranges::upper_bound(plan_.events, progress_.time + same);
  const bool is_end = progress_.nominal + 1 == num_nominal_;
  if (event == plan_.events.end() || *event > nominal + same) {
    return {nominal, false, true};
  }
  const bool is_nominal = std::abs(*event - nominal) <= same;
  return {is_nominal && is_end ? nominal : *event, true, is_nominal};
}

bool StepControl::starts_at_event() const {
  const double same = 0.5 * sliver * plan_.dt;
  return std::ranges::any_of(plan_.events, [&](double event) { return std::abs(event - progress_.time) <= same; });
}

Step StepControl::next() const {
  assert(!finished());
  if (plan_.path) return {progress_.time + progress_.limit, progress_.limit};
  return plan_.adaptive ? next_adaptive(target()) : next_nominal(target());
}

Step StepControl::next_nominal(const Target& target) const {
  const double rest = target.time - progress_.time;
  if (rest <= progress_.limit * (1.0 + sliver)) {
    return {target.time, std::abs(rest - plan_.dt) <= rounding_of(target.time, plan_.origin) ? plan_.dt : rest,
            target.is_event};
  }
  // A remainder of less than two steps is divided equally, so that the second one is not short.
  const double dt = rest < growth * progress_.limit ? 0.5 * rest : progress_.limit;
  return {progress_.time + dt, dt};
}

// Intermediate times are counted back from the target, so that equal steps stay equal to the last bit.
Step StepControl::next_adaptive(const Target& target) const {
  const AdaptivePlan& adaptive = *plan_.adaptive;
  const double rest = target.time - progress_.time;
  double longest = adaptive.max_dt;
  if (progress_.last_dt > 0.0) longest = std::min(longest, adaptive.max_growth * progress_.last_dt);
  const double slack = progress_.rejections > 0 ? sliver : stretch;  // a rejected step must become shorter
  const double num_steps =
      std::max({1.0, std::ceil(rest / progress_.limit - slack), std::ceil(rest / longest - sliver)});
  double dt = rest / num_steps;
  if (std::abs(dt - progress_.last_dt) <= rounding_of(target.time, plan_.origin)) dt = progress_.last_dt;
  if (num_steps > 1.0) return {target.time - (num_steps - 1.0) * dt, dt};
  return {target.time, dt, target.is_event};
}

/// The allowed error of a step: a share of the tolerance equal to its share of the run's duration, but at least a small
/// fraction of the unspent tolerance, and a hundredth of that where steps are hard to estimate. After a start or event
/// estimates are of low order and too large; at a kink that is not an event, and where only rounding and the solver's
/// tolerance are left, the error does not fall as it should. Without this minimum, fast and brief motion would have to
/// be resolved more closely than slow motion, by orders of magnitude.
double StepControl::allowance(const Step& step, bool is_hard) const {
  const double duration = plan_.end - plan_.origin;
  const double unspent = (progress_.time - plan_.origin) / duration + reserve - progress_.spent;
  return std::max(step.dt / duration, (is_hard ? hard_step_part : least_part) * std::clamp(unspent, 0.0, 1.0));
}

/// The error relative to the step's allowed error.
double StepControl::share(const Step& step, double error) const {
  const bool is_hard = progress_.num_after_start < num_start_steps || progress_.rejections >= many_rejections ||
                       !falls_as_it_should(step, error);
  return error / allowance(step, is_hard);
}

/// The power of the step with which this ratio falls: that of the error, less one where the allowed error falls too.
double StepControl::order_of_share(const Step& step) const {
  const bool is_least = allowance(step, false) > step.dt / (plan_.end - plan_.origin);
  return plan_.adaptive->order + (is_least && progress_.num_after_start == num_start_steps ? 1 : 0);
}

/// Whether the step just rejected gives an estimate.
bool StepControl::falls_as_it_should(const Step& step, double error) const {
  const double order = plan_.adaptive->order + 1 - missing_order;
  return progress_.rejections == 0 || progress_.rejected_dt == 0.0 ||
         error <= progress_.rejected_error * std::pow(step.dt / progress_.rejected_dt, order);
}

bool StepControl::stands_still(const Step& step, double error) const {
  return progress_.rejected_dt > step.dt && std::isfinite(error) &&
         error > progress_.rejected_error * std::pow(step.dt / progress_.rejected_dt, standstill);
}

bool StepControl::accepts(double error) const {
  return !plan_.adaptive || share(next(), error) <= 1.0;  // false for NaN
}

std::string StepControl::concession(double error) const {
  if (!plan_.adaptive || accepts(error)) return {};
  const Step step = next();
  if (step.dt > plan_.min_dt * (1.0 + sliver) || !stands_still(step, error)) return {};
  return error_of(step, error) +
         " and is accepted nevertheless: the error does not fall with the step, as at a jump, or if it comes from the "
         "solver; list jumps in time.events, and make solver.newton.relative and absolute small enough";
}

void StepControl::accept(double error) {
  const Target reached = target();
  const Step step = next();
  const bool jumps = !concession(error).empty();
  const bool is_reached = step.time == reached.time;
  progress_.at_event = is_reached && reached.is_event;
  progress_.at_interval = is_reached && reached.is_nominal;
  if (progress_.at_interval) ++progress_.nominal;
  progress_.time = step.time;
  if (plan_.adaptive) {
    if (jumps) {
      progress_.at_event = true;
      progress_.limit = progress_.wanted;
      progress_.rejections = 0;
    }
    adapt(step, error);
  } else if (growth * step.dt >= progress_.limit * (1.0 - sliver)) {  // else an event cut it short
    progress_.limit = std::min(growth * step.dt, plan_.dt);
  }
}

void StepControl::accept_on_path(double end, double growth) {
  assert(plan_.path);
  progress_.time = end;
  progress_.limit = std::clamp(growth * progress_.limit, plan_.min_dt, plan_.path->max_dt);
}

void StepControl::stop() {
  progress_.nominal = num_nominal_;
}

// The PI controller of Gustafsson (Hairer & Wanner II, IV.8; exponents of the error per unit step):
//     dt_new = dt (aim/e)^kI (e_prev/e)^kP,   kI = 0.7/p, kP = 0.3/p
// An error that stays at e is corrected at once, kI + kP = 1/p, and one that was already falling, or rising, the less,
// or the more. The error of a step of another length is scaled to the wanted length; one of less than half of
// it is not informative, and changes nothing.
void StepControl::adapt(const Step& step, double error) {
  const AdaptivePlan& adaptive = *plan_.adaptive;
  const double p = order_of_share(step), wanted = progress_.limit;
  // Past states say nothing about what follows a kink.
  const bool is_kink =
      progress_.num_after_start == num_start_steps && progress_.rejections > 0 && error > allowance(step, false);
  if (step.dt >= 0.5 * wanted) {
    const double e = std::max(share(step, error) * std::pow(wanted / step.dt, p), 1e-10);  // e = 0 would be no number
    const double proposed = std::pow(aim / e, 1.0 / p);
    double factor = proposed;
    if (proposed >= keep_from && proposed <= keep_to) {
      factor = 1.0;
    } else if (progress_.error > 0.0) {
      factor = std::pow(proposed, 0.7) * std::pow(progress_.error / e, 0.3 / p);
    }
    const double most = progress_.rejections > 0 ? 1.0 : std::min(growth, adaptive.max_growth);
    progress_.limit = std::clamp(wanted * std::clamp(factor, strongest_cut, most), plan_.min_dt, adaptive.max_dt);
    progress_.error = e;
    progress_.rejections = 0;
  }
  progress_.last_dt = step.dt;
  progress_.num_after_start = is_kink ? 0 : std::min(progress_.num_after_start + 1, num_start_steps);
  if (progress_.at_event || step.dt >= progress_.rejected_dt) progress_.rejected_dt = progress_.rejected_error = 0.0;
  if (std::isfinite(error)) progress_.spent += error;
  if (progress_.at_event) {
    progress_.limit = std::max(after_event * progress_.limit, plan_.min_dt);
    progress_.last_dt = 0.0;
    progress_.error = 0.0;
    progress_.num_after_start = 0;
  }
}

RetryDecision StepControl::reject(const std::string& reason) {
  const Step step = next();
  const std::string failure = "step of " + quantity(step.dt) + " from " + plan_.variable.name + " = " +
                              quantity(progress_.time) + " failed: " + reason;
  const double half = 0.5 * step.dt;
  if (half < plan_.min_dt) {
    return {Retry::give_up, failure + "; half of it is below the smallest step allowed, " + quantity(plan_.min_dt)};
  }
  return shorten(step, half, failure);
}

RetryDecision StepControl::reject_error(double error) {
  assert(plan_.adaptive);
  const Step step = next();
  const double e = share(step, error);
  const std::string failure = error_of(step, error);
  if (step.dt <= plan_.min_dt * (1.0 + sliver)) {
    return {Retry::give_up, failure + ", and the smallest step allowed is " + quantity(plan_.min_dt) +
                                (std::isfinite(e) ? "; the error falls with the step: allow a smaller "
                                                    "time.adaptive.min_step, or a larger time.adaptive.relative"
                                                  : "")};
  }
  if (progress_.rejected_dt == 0.0) progress_.wanted = progress_.limit;
  progress_.rejected_dt = step.dt;
  progress_.rejected_error = error;
  const double factor = std::isfinite(e) ? std::pow(aim / e, 1.0 / order_of_share(step)) : strongest_cut;
  return shorten(step, std::max(step.dt * std::clamp(factor, strongest_cut, largest_retry), plan_.min_dt), failure);
}

std::string StepControl::error_of(const Step& step, double error) const {
  char times[32];
  std::snprintf(times, sizeof times, "%.3g", share(step, error));
  return "step of " + quantity(step.dt) + " from " + plan_.variable.name + " = " + quantity(progress_.time) + " has " +
         times + " times the allowed error";
}

RetryDecision StepControl::shorten(const Step& step, double dt, const std::string& failure) {
  assert(dt < step.dt);
  progress_.limit = dt;
  progress_.error = 0.0;
  ++progress_.rejections;
  return {Retry::again, failure + "; trying " + quantity(dt)};
}

std::string StepControl::quantity(double value) const {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return plan_.variable.unit.empty() ? text : text + (" " + plan_.variable.unit);
}

}  // namespace pliant
