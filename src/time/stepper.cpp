#include "time/stepper.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace pliant {

Stepper::Stepper(const Method& method, StageSolve solve, PrescribedMotion motion, Guess guess, Vec layout)
    : method_(method), solve_(std::move(solve)), motion_(std::move(motion)), guess_(guess) {
  base_ = make_pair(layout);
  start_ = make_pair(layout);
  stage_ = make_pair(layout);
  end_ = method_.stiffly_accurate ? Pair{stage_.q.share(), stage_.v.share()} : make_pair(layout);
  check(VecDuplicate(layout, a_.out()));
  const int num_increments = method_.stiffly_accurate ? method_.num_stages - 1 : method_.num_stages;
  for (int i = 0; i < num_increments; ++i) {
    increments_.push_back(make_pair(layout));
    increments_q_.push_back(increments_.back().q.get());
    increments_v_.push_back(increments_.back().v.get());
  }
}

Stepper::Pair Stepper::make_pair(Vec layout) const {
  Pair y;
  check(VecDuplicate(layout, y.q.out()));
  check(VecDuplicate(layout, y.v.out()));
  return y;
}

StepAttempt Stepper::attempt(const History& history, const Step& step) & {
  assert(step.time > history.newest().time && step.dt > 0.0);
  const BdfWeights w = weights(history, step);
  set_base(history, w.alpha);
  StepAttempt attempt;
  attempt.time = step.time;
  for (std::size_t i = 0; i < method_.b.size(); ++i) {
    StagePoint stage;
    stage.time = step.time - w.beta * (1.0 - method_.c[i]) * step.dt;  // exactly the end of the step for c_i = 1
    stage.dt = w.beta * method_.A[i][i] * step.dt;
    stage.step_start = history.newest().time;
    stage.q0 = start_.q.get();
    stage.v0 = start_.v.get();
    start_stage(i, stage);
    const StageReport report = solve_(stage, stage_.q.get());
    attempt.report.newton_iterations += report.newton_iterations;
    attempt.report.linear_iterations += report.linear_iterations;
    if (report.outcome != StageOutcome::converged) {
      attempt.report.outcome = report.outcome;
      attempt.report.reason = report.reason;
      return attempt;
    }
    end_stage(i, stage);
    attempt.last_stage = stage;
  }
  complete_step(step);
  attempt.q = end_.q.get();
  attempt.v = end_.v.get();
  attempt.last_q = stage_.q.get();
  attempt.last_a = a_.get();
  return attempt;
}

BdfWeights Stepper::weights(const History& history, const Step& step) {
  past_times_.clear();
  for (int r = 0; r < std::min(history.size(), method_.num_steps); ++r) past_times_.push_back(history[r].time);
  const auto num_used = static_cast<std::size_t>(num_usable_states(past_times_, step));
  return bdf_weights(std::span(past_times_).first(num_used), step);
}

// y* = y_n + sum_{r>=2} alpha_r (y_{n+1-r} - y_n)
void Stepper::set_base(const History& history, const std::vector<double>& alpha) {
  const State& newest = history.newest();
  check(VecCopy(newest.q.get(), base_.q.get()));
  check(VecCopy(newest.v.get(), base_.v.get()));
  for (std::size_t r = 1; r < alpha.size(); ++r) {
    const State& older = history[static_cast<int>(r)];
    check(VecWAXPY(stage_.q.get(), -1.0, newest.q.get(), older.q.get()));
    check(VecWAXPY(stage_.v.get(), -1.0, newest.v.get(), older.v.get()));
    check(VecAXPY(base_.q.get(), alpha[r], stage_.q.get()));
    check(VecAXPY(base_.v.get(), alpha[r], stage_.v.get()));
  }
}

// Y_i0 = y* + sum_{j<i} At_ij (Y_j - y*), and the guess
void Stepper::start_stage(std::size_t i, const StagePoint& stage) {
  const auto num_earlier = static_cast<PetscInt>(i);
  check(VecCopy(base_.q.get(), stage.q0));
  check(VecCopy(base_.v.get(), stage.v0));
  if (num_earlier > 0) {
    check(VecMAXPY(stage.q0, num_earlier, method_.At[i].data(), increments_q_.data()));
    check(VecMAXPY(stage.v0, num_earlier, method_.At[i].data(), increments_v_.data()));
  }
  switch (guess_) {
    case Guess::start:
      check(VecCopy(stage.q0, stage_.q.get()));
      break;
    case Guess::extrapolated:
      check(VecWAXPY(stage_.q.get(), stage.dt, stage.v0, stage.q0));
      break;
  }
  motion_.start_stage(stage, stage_.q.get());
}

// v_i = (q_i - q_i0) / dt_i, and Y_i - y* where it is needed again; a_s = (v_s - v_s0) / dt_s
void Stepper::end_stage(std::size_t i, const StagePoint& stage) {
  check(VecWAXPY(stage_.v.get(), -1.0, stage.q0, stage_.q.get()));
  check(VecScale(stage_.v.get(), 1.0 / stage.dt));
  if (i < increments_.size()) {
    check(VecWAXPY(increments_q_[i], -1.0, base_.q.get(), stage_.q.get()));
    check(VecWAXPY(increments_v_[i], -1.0, base_.v.get(), stage_.v.get()));
  }
  if (i + 1 == method_.b.size()) {
    check(VecWAXPY(a_.get(), -1.0, stage.v0, stage_.v.get()));
    check(VecScale(a_.get(), 1.0 / stage.dt));
  }
}

// y_{n+1} = y* + sum_i bt_i (Y_i - y*); of a stiffly accurate method it is Y_s, in place already
void Stepper::complete_step(const Step& step) {
  if (!method_.stiffly_accurate) {
    const auto s = static_cast<PetscInt>(method_.b.size());
    check(VecCopy(base_.q.get(), end_.q.get()));
    check(VecCopy(base_.v.get(), end_.v.get()));
    check(VecMAXPY(end_.q.get(), s, method_.bt.data(), increments_q_.data()));
    check(VecMAXPY(end_.v.get(), s, method_.bt.data(), increments_v_.data()));
  }
  motion_.complete_step(step, end_.q.get(), end_.v.get());
}

void accept(const StepAttempt& attempt, History& history) {
  assert(attempt.report.outcome == StageOutcome::converged);
  history.push(attempt.time, attempt.q, attempt.v);
}

}  // namespace pliant
