/// A method with its start-up and its history: takes one step after another.
#pragma once

#include "time/error_estimate.hpp"
#include "time/startup.hpp"
#include "time/stepper.hpp"

#include <optional>

namespace pliant {

struct IntegratorOptions {
  Method method;
  Startup startup = Startup::ramp;
  ErrorEstimate estimate = ErrorEstimate::none;
};

/// Steppers and history of one motion. An attempt leaves no trace unless it is accepted.
///
/// Where a method needs equal steps (Method::needs_equal_steps) and the step is not the last of as many, the start-up
/// method takes it: dirk33, or bdf3 with its ramp.
class Integrator {
 public:
  /// Starts from a copy of `initial`. Collective.
  Integrator(const IntegratorOptions& options, System system, const StateView& initial);

  /// Tries the step from the newest state; allocates nothing. Estimates the error if that was requested and the method
  /// has an estimate. Collective.
  StepAttempt attempt(const Step& step) &;
  /// Begins the step to be taken stage by stage: the stepper that takes it. Errors are not estimated. Collective.
  Stepper& begin(const Step& step) &;
  /// Makes the last attempt, which converged, the newest state. Collective.
  void accept(const StepAttempt& attempt);
  /// Forgets all but the newest state and starts the method again: after an event at which prescribed velocities or
  /// accelerations jump, past states say nothing about what follows. The newest velocity becomes that after the event.
  /// Collective.
  void restart();
  /// Sets the quadratures of the newest state: changes at a restart are not part of a step.
  void set_quadratures(std::span<const double> w) { history_.set_quadratures(w); }
  /// Adds to the quadratures of all states (History::shift_quadratures): formulas of methods with past states do not
  /// take the change for a rate.
  void shift_quadratures(std::span<const double> change) { history_.shift_quadratures(change); }
  /// Collective.
  void keep(Archive& archive);

  /// The newest accepted state.
  const State& state() const { return history_.newest(); }
  const Method& method() const { return stepper_.method(); }
  /// The stepper that tried or began the last step; nullptr if none did.
  const Stepper* last_stepper() const { return last_stepper_; }

 private:
  /// The stepper that takes the step.
  Stepper& choose(const Step& step);

  PrescribedMotion motion_;
  double last_dt_ = 0.0;  // of the last step accepted
  const Stepper* last_stepper_ = nullptr;
  Stepper stepper_;
  std::optional<Stepper> starter_;
  std::optional<LocalError> error_;
  History history_;
};

}  // namespace pliant
