#include "run/static_states.hpp"

#include "petsc/check.hpp"

#include <utility>

namespace pliant {

StaticStates::StaticStates(double time, Model& model, const StateView& initial)
    : time_(time), motion_(model.constraints().motion()), internal_(model.potential().internal_variables()) {
  for (Handle<Vec>* v : {&last_, &earlier_, &q_, &start_, &zero_, &start_velocity_}) *v = make_vector(model.layout());
  check(VecCopy(initial.q, last_.get()));
  if (initial.z == nullptr) return;
  for (Handle<Vec>* z : {&last_z_, &z_}) check(VecDuplicate(initial.z, z->out()));
  check(VecCopy(initial.z, last_z_.get()));
}

const StagePoint& StaticStates::begin_stage(double load_factor, Vec q) {
  stage_ = {.time = time_,
            .dt = 1.0,
            .q0 = start_.get(),
            .v0 = start_velocity_.get(),
            .load_factor = load_factor,
            .step_start = time_ - 1.0,
            .z0 = last_z_.get(),
            .accepted = last(),
            .accepted_z = last_z_.get()};
  motion_.start_stage(stage_, q);
  // Time stands still: prescribed functions of time have no rate.
  check(VecCopy(last(), start_.get()));
  check(VecSet(start_velocity_.get(), 0.0));
  return stage_;
}

StepAttempt StaticStates::end_step(double time) {
  StepAttempt result;
  result.time = time;
  result.load_factor = stage_.load_factor;
  result.last_stage = stage_;
  result.q = result.last_q = q_.get();
  result.v = result.last_a = zero_.get();
  if (!z_) return result;
  check(VecCopy(last_z_.get(), z_.get()));
  internal_.complete_step(last_z_.get(), q_.get(), z_.get());
  result.z = z_.get();
  return result;
}

void StaticStates::accept(const StepAttempt& attempt) {
  check(VecCopy(last(), earlier()));
  earlier_load_factor_ = std::exchange(load_factor_, attempt.load_factor);
  check(VecCopy(attempt.q, last()));
  if (last_z_) check(VecCopy(attempt.z, last_z_.get()));
}

void StaticStates::keep(Archive& archive) {
  archive.number("load_factor", load_factor_);
  archive.vector("q", Entries::nodes, last());
  archive.number("earlier_load_factor", earlier_load_factor_);
  archive.vector("earlier_q", Entries::nodes, earlier());
  if (last_z_) archive.vector("z", Entries::internal, last_z_.get());
}

}  // namespace pliant
