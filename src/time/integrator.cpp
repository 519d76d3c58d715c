#include "time/integrator.hpp"

#include <utility>

namespace pliant {

Integrator::Integrator(const IntegratorOptions& options, System system, const StateView& initial)
    : stepper_(options.method, system, initial), history_(options.method.num_steps, initial) {
  if (options.startup == Startup::dirk33 && options.method.num_steps > 1) {
    starter_.emplace(*find_method("dirk33"), std::move(system), initial);
  }
}

StepAttempt Integrator::attempt(const Step& step) & {
  const bool starting = history_.size() < method().num_steps;
  return starting && starter_ ? starter_->attempt(history_, step) : stepper_.attempt(history_, step);
}

void Integrator::accept(const StepAttempt& attempt) {
  pliant::accept(attempt, history_);
}

void Integrator::restart() {
  history_.forget();
}

}  // namespace pliant
