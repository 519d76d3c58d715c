#include "solver/escalation.hpp"

namespace pliant {

void Escalation::factorized() {
  if (state_ == State::kept_factor) state_ = State::fresh_factor;
}

void Escalation::shifted() {
  state_ = is_projected() ? State::projected_and_shifted : State::made_definite;
}

Escalation::State Escalation::escalate(Permission permission) {
  if (permission == Permission::nothing) return state_ = State::smaller_step;
  switch (state_) {
    case State::kept_factor:
      return state_ = State::fresh_factor;
    case State::fresh_factor:
    case State::made_definite:
      return state_ = permission == Permission::exact_hessian ? State::smaller_step : State::projected;
    case State::projected:
      return state_ = permission == Permission::exact_hessian ? State::smaller_step : State::projected_and_shifted;
    case State::projected_and_shifted:
    case State::smaller_step:
      return state_ = State::smaller_step;
  }
  return state_;
}

}  // namespace pliant
