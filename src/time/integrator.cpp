#include "time/integrator.hpp"

#include <algorithm>
#include <cassert>
#include <string_view>
#include <utility>

namespace pliant {
namespace {

/// The method that starts another one; nullptr if that starts by itself.
const Method* starter_of(const IntegratorOptions& options) {
  if (options.method.num_steps == 1) return nullptr;
  if (options.startup == Startup::dirk33) return find_method("dirk33");
  return options.method.needs_equal_steps ? find_method("bdf3") : nullptr;
}

int history_depth(const IntegratorOptions& options, Guess guess, const std::optional<LocalError>& error) {
  const Method* starter = starter_of(options);
  return std::max(
      {options.method.num_steps, starter ? starter->num_steps : 1, error ? error->num_states() : 1, num_states(guess)});
}

}  // namespace

Integrator::Integrator(const IntegratorOptions& options, System system, const StateView& initial)
    : motion_(system.motion),
      stepper_(options.method, system, initial),
      error_(options.estimate == ErrorEstimate::local
                 ? std::optional<LocalError>(std::in_place, options.method, system.space, initial)
                 : std::nullopt),
      history_(history_depth(options, system.guess, error_), initial) {
  if (const Method* starter = starter_of(options)) starter_.emplace(*starter, std::move(system), initial);
}

Stepper& Integrator::choose(const Step& step) {
  const bool starts = history_.size() < method().num_steps || !stepper_.can_take(history_, step);
  Stepper& stepper = starter_ && starts ? *starter_ : stepper_;
  last_stepper_ = &stepper;
  return stepper;
}

Stepper& Integrator::begin(const Step& step) & {
  Stepper& stepper = choose(step);
  stepper.begin(history_, step);
  return stepper;
}

StepAttempt Integrator::attempt(const Step& step) & {
  Stepper& stepper = choose(step);
  StepAttempt attempt = stepper.attempt(history_, step);
  if (error_ && attempt.report.outcome == StageOutcome::converged) {
    error_->estimate(history_, stepper, attempt);
    if (attempt.error_v != nullptr) motion_.project_error(attempt.q, attempt.error_v);
  }
  return attempt;
}

void Integrator::accept(const StepAttempt& attempt) {
  last_dt_ = attempt.time - history_.newest().time;
  pliant::accept(attempt, history_);
  if (starter_ && last_stepper_ == &*starter_) {
    starter_->accept();
    stepper_.restart();
  } else {
    stepper_.accept();
    if (starter_) starter_->restart();
  }
  if (error_) error_->accept(attempt);
}

void Integrator::keep(Archive& archive) {
  archive.number("last_dt", last_dt_);
  {
    const Archive::Section section(archive, "history");
    history_.keep(archive);
  }
  {
    const Archive::Section section(archive, "stages");
    stepper_.keep(archive);
  }
  if (starter_) {
    const Archive::Section section(archive, "starter");
    starter_->keep(archive);
  }
  if (!error_) return;
  const Archive::Section section(archive, "error");
  error_->keep(archive);
}

void Integrator::restart() {
  const State& newest = history_.restart();
  stepper_.restart();
  if (starter_) starter_->restart();
  motion_.restart({newest.time, last_dt_}, newest.q.get(), newest.v.get());
  if (error_) error_->restart();
}

}  // namespace pliant
