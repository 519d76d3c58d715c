/// The states of a static problem: those accepted last, and the stage that starts at the last one.
#pragma once

#include "energy/equation/incremental_potential.hpp"
#include "model/model.hpp"
#include "petsc/archive.hpp"
#include "time/integrator.hpp"

namespace pliant {

/// Formulas are evaluated at one time; what changes from state to state is the load factor. All methods are collective.
class StaticStates {
 public:
  /// `time`: at which formulas are evaluated [s]. `model` outlives the object.
  StaticStates(double time, Model& model, const StateView& initial);

  /// The stage at this load factor, valid until the next call; sets the prescribed entries of `q`.
  const StagePoint& begin_stage(double load_factor, Vec q);
  /// The configuration that a step looks for.
  Vec unknown() const { return q_.get(); }
  /// The step that ends with the last stage, with `unknown` as its solution.
  StepAttempt end_step(double time);
  void accept(const StepAttempt& attempt);

  double load_factor() const { return load_factor_; }
  double earlier_load_factor() const { return earlier_load_factor_; }
  Vec last() const { return last_.get(); }
  Vec earlier() const { return earlier_.get(); }
  StateView view(double time) const { return {time, last(), zero_.get(), last_z_.get(), {}, load_factor_}; }
  void keep(Archive& archive);

 private:
  double time_;
  PrescribedMotion motion_;
  InternalVariables internal_;
  StagePoint stage_;
  double load_factor_ = 0.0, earlier_load_factor_ = 0.0;
  Handle<Vec> last_, earlier_, q_, start_, zero_, start_velocity_;
  Handle<Vec> last_z_, z_;  // null if there are none
};

}  // namespace pliant
