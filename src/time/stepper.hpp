/// One step of a method: its stages one after another, each handed to a solver. Depends on no equation except q' = v.
#pragma once

#include "petsc/handle.hpp"
#include "time/bdf.hpp"
#include "time/method.hpp"
#include "time/space.hpp"
#include "time/stage.hpp"
#include "time/stage_predictor.hpp"
#include "time/stage_variable.hpp"
#include "time/state.hpp"
#include "time/step.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace pliant {

/// Where the solver of a stage starts from.
enum class Guess {
  start,         ///< q_i0
  extrapolated,  ///< q_i0 + dt_i v_i0, where inertia alone would lead; on a vector space the stage's solution lies
                 ///< exactly dt_i^2 a_i from it
  predicted      ///< q_i0 + dt_i v_i0 + dt_i^2 a, a by the polynomial through those of the last steps
                 ///< (StagePredictor), or such that the velocity lies on the parabola through those of three states
                 ///< (the line through two); extrapolated where there is one state, or a space
};

/// What moves: the equation of a stage and all that goes with it.
struct System {
  StageSolve solve;
  PrescribedMotion motion = {};
  InternalVariables internal = {};                            ///< used if the states have z
  Quadratures quadratures = {};                               ///< used if the states have w
  std::shared_ptr<const ConfigurationSpace> space = nullptr;  ///< nullptr: a vector space
  Guess guess = Guess::start;
};

/// What came of trying a step. Nothing of it is in the history until it is accepted. Vectors and numbers are borrowed,
/// valid until the next attempt; unless the outcome is `converged` they are undefined.
struct StepAttempt {
  StageReport report;              ///< outcome and reason of the step; iterations are summed over the stages
  double time = 0.0;               ///< end of the step [s]
  Vec q = nullptr;                 ///< configuration at the end of the step [m]
  Vec v = nullptr;                 ///< velocity at the end of the step [m/s]
  Vec z = nullptr;                 ///< internal variables at the end of the step; nullptr if there are none
  std::span<const double> w = {};  ///< quadratures at the end of the step
  StagePoint last_stage;           ///< the last stage; its residual at `last_q` holds the reaction forces
  Vec last_q = nullptr;  ///< the unknown at the end of the last stage: q_s [m], or coordinates around last_stage.centre
  Vec a = nullptr;  ///< acceleration at the end of the step [m/s^2]; nullptr if no stage is there (unless the method
                    ///< is stiffly accurate)
  Vec last_a = nullptr;  ///< acceleration of the last stage, (v_s - v_s0) / dt_s [m/s^2]

  /// Estimated error that the step adds, y_{n+1} minus the exact motion from y_n; nullptr if there is no estimate.
  /// Coordinates around q_n, if there is a space.
  Vec error_q = nullptr;   ///< [m]
  Vec error_v = nullptr;   ///< [m/s]
  int estimate_order = 0;  ///< the estimate falls as dt^(estimate_order + 1)

  double load_factor = 1.0;  ///< StagePoint::load_factor at the end of the step

  StateView view() const { return {time, q, v, z, w, load_factor}; }
};

/// Takes steps of a method.
///
/// Backward differentiation formulas start by a ramp: with fewer accepted states than the method wants, the formula of
/// as many states as there are is used (first backward Euler). For another start-up let another stepper take the first
/// steps into the same history (time/integrator.hpp does). With changing steps the formula's weights follow the actual
/// times; where a step grows beyond the formula's limit (Method::max_growth), that step and those which see the jump
/// use the formula with one state less. Other methods with several past states (Method::needs_equal_steps) take only
/// steps that continue as many equal ones.
class Stepper {
 public:
  /// Vectors are made like those of `like`. Collective.
  Stepper(const Method& method, System system, const StateView& like);

  /// Tries the step from the newest state of `history` to `step.time`; takes no memory. Collective.
  StepAttempt attempt(const History& history, const Step& step) &;
  /// The last attempt is in the history, and guesses may build upon it. Collective.
  void accept();
  /// What comes next does not continue steps of this stepper.
  void restart();

  /// The same stage by stage, with solutions that are found elsewhere: `begin`, for each stage `start_stage` and
  /// `end_stage` with its solution in `unknown`, then `end_step`. `history` outlives the step. Collective.
  void begin(const History& history, const Step& step);
  /// The next stage, with a guess in `unknown`; valid until the next call.
  const StagePoint& start_stage();
  void end_stage();
  StepAttempt end_step();
  /// The solution of the present stage, as System::solve takes and leaves it.
  Vec unknown() const { return q_.stage(); }

  /// Whether the method can take the step.
  bool can_take(const History& history, const Step& step) const;
  /// Collective.
  void keep(Archive& archive);
  /// q, v = sum_i (bt - bt_embedded)_i (Y_i - y*) of the last attempt, which converged: the difference to a formula of
  /// the order Method::embedded_order. Collective.
  void embedded_difference(Vec q, Vec v) const;

  const Method& method() const { return method_; }
  /// The weights of the past states in the step that was begun last.
  const BdfWeights& weights_of_step() const { return weight_; }

 private:
  BdfWeights weights(const History& history, const Step& step);
  void set_base(const History& history, std::span<const double> alpha);
  void start(StagePoint& stage);
  void complete_step();
  /// Solves the present stage, from another guess if a predicted one leads to no solution.
  StageReport solve_stage();
  void predict(const StagePoint& stage, Vec q);
  void set_guess(const StagePoint& stage, Vec a, Vec q) const;
  /// Sets a to the change of v0 that puts the velocity on the curve through those of the newest states, over dt.
  void continue_velocity(const StagePoint& stage, Vec a) const;

  Method method_;
  System system_;
  StageVariable q_;  // coordinates, if there is a space
  StageVariable v_;
  std::optional<StageVariable> z_;
  std::vector<double> w_, rates_;
  std::vector<double> embedded_;  // bt - bt_embedded
  Handle<Vec> a_;
  std::optional<StagePredictor> predictor_;
  // The step that was begun last, and its present stage.
  const History* history_ = nullptr;
  Step step_;
  BdfWeights weight_;
  std::size_t number_ = 0;  // of the stage, from 0
  StagePoint stage_;
  // Only for problems with a space: the coordinates of the past states, xi' of a stage, the configuration at the end of
  // the step.
  std::vector<Handle<Vec>> charted_;
  Handle<Vec> rate_, end_q_;
  Handle<Vec> midpoint_rest_;  // StagePoint::end_rest of the midpoint rules before the last
  // The past states, newest first.
  std::vector<double> past_times_;
  std::vector<Vec> past_q_, past_v_, past_z_;
};

/// How many states the guess needs at most.
constexpr int num_states(Guess guess) {
  return guess == Guess::predicted ? 3 : 1;
}

/// Makes a converged attempt the newest state of the history. Collective.
void accept(const StepAttempt& attempt, History& history);

}  // namespace pliant
