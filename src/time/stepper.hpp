/// One step of a method: its stages one after another, each handed to a solver. Knows no equation but q' = v.
#pragma once

#include "petsc/handle.hpp"
#include "time/bdf.hpp"
#include "time/method.hpp"
#include "time/stage.hpp"
#include "time/state.hpp"
#include "time/step.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Where the solver of a stage starts from.
enum class Guess {
  start,        ///< q_i0
  extrapolated  ///< q_i0 + dt_i v_i0, where inertia alone would lead; the stage's solution lies exactly dt_i^2 a_i from
                ///< it
};

/// What came of trying a step. Nothing of it is in the history until it is accepted. The vectors are the stepper's, and
/// are valid until its next attempt; unless the outcome is `converged` they are undefined.
struct StepAttempt {
  StageReport report;     ///< outcome and reason of the step; iterations are summed over the stages
  double time = 0.0;      ///< end of the step [s]
  Vec q = nullptr;        ///< configuration at the end of the step [m]
  Vec v = nullptr;        ///< velocity at the end of the step [m/s]
  StagePoint last_stage;  ///< the last stage; its residual at `last_q` holds the reaction forces
  Vec last_q = nullptr;   ///< configuration at the end of the last stage, q_s [m]
  Vec last_a = nullptr;   ///< acceleration of the last stage, (v_s - v_s0) / dt_s [m/s^2]
};

/// Takes steps of a method.
///
/// Multistep methods start by a ramp: with fewer accepted states than the method wants, the formula of as many states
/// as there are is used (first backward Euler). For another start-up let another stepper take the first steps into the
/// same history. With changing steps the formula's weights follow the actual times; where a step grows beyond the
/// formula's limit (Method::max_growth), that step and those which see the jump use the formula with one state less.
class Stepper {
 public:
  /// Vectors are made like `layout`. Collective.
  Stepper(const Method& method, StageSolve solve, PrescribedMotion motion, Guess guess, Vec layout);

  /// Tries the step from the newest state of `history` to `step.time`; allocates no vectors. Collective.
  StepAttempt attempt(const History& history, const Step& step) &;

  const Method& method() const { return method_; }

 private:
  struct Pair {
    Handle<Vec> q, v;
  };
  Pair make_pair(Vec layout) const;
  BdfWeights weights(const History& history, const Step& step);
  void set_base(const History& history, const std::vector<double>& alpha);
  void start_stage(std::size_t i, const StagePoint& stage);
  void end_stage(std::size_t i, const StagePoint& stage);
  void complete_step(const Step& step);

  Method method_;
  StageSolve solve_;
  PrescribedMotion motion_;
  Guess guess_;
  std::vector<double> past_times_;  // newest first
  Pair base_;                       // y*
  Pair start_;                      // Y_i0
  Pair stage_;                      // Y_i
  Pair end_;                        // y_{n+1}; shares the vectors of stage_ if the method is stiffly accurate
  Handle<Vec> a_;
  std::vector<Pair> increments_;  // Y_i - y*, of the stages that later ones or the end need
  std::vector<Vec> increments_q_, increments_v_;
};

/// Makes a converged attempt the newest state of the history. Collective.
void accept(const StepAttempt& attempt, History& history);

}  // namespace pliant
