#include "time/stepper.hpp"

#include "time/extrapolation.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace pliant {
Stepper::Stepper(const Method& method, System system, const StateView& like)
    : method_(method),
      system_(std::move(system)),
      q_(method, system_.space ? like.v : like.q),
      v_(method, like.v),
      w_(like.w.size()),
      rates_(like.w.size()) {
  if (like.z != nullptr) z_.emplace(method, like.z);
  check(VecDuplicate(like.v, a_.out()));
  for (std::size_t i = 0; i < method_.bt_embedded.size(); ++i)
    embedded_.push_back(method_.bt[i] - method_.bt_embedded[i]);
  if (method_.symplectic && method_.num_stages > 1) check(VecDuplicate(like.v, midpoint_rest_.out()));
  const auto l = static_cast<std::size_t>(method_.num_steps);
  if (system_.guess == Guess::predicted && !system_.space) predictor_.emplace(method_.num_stages, a_.get());
  if (system_.space) {
    check(VecDuplicate(like.v, rate_.out()));
    check(VecDuplicate(like.q, end_q_.out()));
    charted_.resize(l);
    for (auto& xi : charted_) check(VecDuplicate(like.v, xi.out()));
    check(VecZeroEntries(charted_[0].get()));  // the coordinates of q_n around itself
  }
  past_times_.reserve(l);
  for (auto* past : {&past_q_, &past_v_, &past_z_}) past->reserve(l);
}

StepAttempt Stepper::attempt(const History& history, const Step& step) & {
  begin(history, step);
  StageReport total;
  for (int i = 0; i < method_.num_stages; ++i) {
    start_stage();
    const StageReport report = solve_stage();
    total.newton_iterations += report.newton_iterations;
    total.linear_iterations += report.linear_iterations;
    if (report.outcome != StageOutcome::converged) {
      total.outcome = report.outcome;
      total.reason = report.reason;
      StepAttempt failed;
      failed.time = step.time;
      failed.report = total;
      return failed;
    }
    end_stage();
  }
  StepAttempt attempt = end_step();
  attempt.report = total;
  return attempt;
}

StageReport Stepper::solve_stage() {
  StageReport first = system_.solve(stage_, unknown());
  if (first.outcome != StageOutcome::retry || !predictor_ || !predictor_->withdraw(a_.get())) return first;
  set_guess(stage_, a_.get(), unknown());
  system_.motion.start_stage(stage_, unknown());
  StageReport second = system_.solve(stage_, unknown());
  second.newton_iterations += first.newton_iterations;
  second.linear_iterations += first.linear_iterations;
  return second;
}

void Stepper::begin(const History& history, const Step& step) {
  assert(step.time > history.newest().time && step.dt > 0.0);
  history_ = &history;
  step_ = step;
  number_ = 0;
  weight_ = weights(history, step);
  set_base(history, weight_.alpha());
  if (predictor_) predictor_->begin();
}

void Stepper::accept() {
  if (predictor_) predictor_->accept();
}

void Stepper::restart() {
  if (predictor_) predictor_->restart();
}

void Stepper::keep(Archive& archive) {
  if (predictor_) predictor_->keep(archive);
}

const StagePoint& Stepper::start_stage() {
  const std::size_t i = number_;
  stage_ = {};
  // Exactly the end of the step for c_i = 1.
  stage_.time = step_.time - weight_.beta * (1.0 - method_.c[i]) * step_.dt;
  // A stage at the end of a step sees what jumps there with its value before the jump.
  if (step_.ends_at_event && stage_.time == step_.time) {
    stage_.time = std::nextafter(step_.time, step_.time - step_.dt);
  }
  stage_.dt = weight_.beta * method_.A[i][i] * step_.dt;
  stage_.step_start = history_->newest().time;
  (system_.space ? stage_.centre : stage_.accepted) = history_->newest().q.get();
  stage_.accepted_z = history_->newest().z.get();
  stage_.end_time = step_.time;
  start(stage_);
  return stage_;
}

StepAttempt Stepper::end_step() {
  complete_step();
  StepAttempt attempt;
  attempt.time = step_.time;
  attempt.q = system_.space ? end_q_.get() : q_.end();
  attempt.v = v_.end();
  if (z_) attempt.z = z_->end();
  attempt.w = w_;
  if (method_.stiffly_accurate) attempt.a = a_.get();
  attempt.last_stage = stage_;
  attempt.last_q = q_.stage();
  attempt.last_a = a_.get();
  return attempt;
}

bool Stepper::can_take(const History& history, const Step& step) const {
  if (!method_.needs_equal_steps) return true;
  if (history.size() < method_.num_steps) return false;
  std::array<double, max_bdf_steps> past_times{};
  const auto l = static_cast<std::size_t>(method_.num_steps);
  for (std::size_t r = 0; r < l; ++r) past_times[r] = history[static_cast<int>(r)].time;
  return are_equal_steps(std::span(past_times).first(l), step);
}

BdfWeights Stepper::weights(const History& history, const Step& step) {
  if (method_.needs_equal_steps) {
    assert(can_take(history, step));
    BdfWeights table{{}, method_.alpha.size(), method_.beta};
    std::ranges::copy(method_.alpha, table.values.begin());
    return table;
  }
  past_times_.clear();
  for (int r = 0; r < std::min(history.size(), method_.num_steps); ++r) past_times_.push_back(history[r].time);
  const auto num_used = static_cast<std::size_t>(num_usable_states(past_times_, step));
  return bdf_weights(std::span(past_times_).first(num_used), step);
}

// y*; of w only w* - w_n, to keep the digits of small contributions
void Stepper::set_base(const History& history, std::span<const double> alpha) {
  for (auto* past : {&past_q_, &past_v_, &past_z_}) past->clear();
  std::ranges::fill(w_, 0.0);
  const State& newest = history.newest();
  for (std::size_t r = 0; r < alpha.size(); ++r) {
    const State& state = history[static_cast<int>(r)];
    if (system_.space && r > 0) system_.space->difference(newest.q.get(), state.q.get(), charted_[r].get());
    past_q_.push_back(system_.space ? charted_[r].get() : state.q.get());
    past_v_.push_back(state.v.get());
    past_z_.push_back(state.z.get());
    for (std::size_t m = 0; r > 0 && m < w_.size(); ++m) w_[m] += alpha[r] * (state.w[m] - newest.w[m]);
  }
  q_.set_base(past_q_, alpha);
  v_.set_base(past_v_, alpha);
  if (z_) z_->set_base(past_z_, alpha);
}

// Y_i0, and the guess
void Stepper::start(StagePoint& stage) {
  const std::size_t i = number_;
  for (StageVariable* y : {&q_, &v_, z_ ? &*z_ : nullptr}) {
    if (y != nullptr) y->start_stage(method_.At[i]);
  }
  stage.q0 = q_.start();
  stage.v0 = v_.start();
  if (i + 1 == method_.b.size() && !system_.space) {
    q_.start_last_stage(method_.bt);
    stage.end_weight = method_.bt[i];
    stage.end_rest = method_.stiffly_accurate ? nullptr : q_.end();
  } else if (method_.symplectic && !system_.space) {
    // A_ii = b_i / 2 and A_ij = b_j: stage i is the middle of a step of the length b_i dt from q_i0 to 2 q_i - q_i0.
    check(VecCopy(stage.q0, midpoint_rest_.get()));
    check(VecScale(midpoint_rest_.get(), -1.0));
    stage.end_weight = 2.0;
    stage.end_rest = midpoint_rest_.get();
    stage.end_time = stage.time + stage.dt;
  }
  if (z_) stage.z0 = z_->start();
  switch (system_.guess) {
    case Guess::start:
      check(VecCopy(stage.q0, q_.stage()));
      break;
    case Guess::extrapolated:
      check(VecWAXPY(q_.stage(), stage.dt, stage.v0, stage.q0));
      break;
    case Guess::predicted:
      predict(stage, q_.stage());
      break;
  }
  system_.motion.start_stage(stage, q_.stage());
}

void Stepper::predict(const StagePoint& stage, Vec q) {
  if (!predictor_) {
    check(VecWAXPY(q, stage.dt, stage.v0, stage.q0));
    return;
  }
  continue_velocity(stage, a_.get());
  predictor_->predict(number_, stage.time, a_.get());
  set_guess(stage, a_.get(), q);
}

void Stepper::set_guess(const StagePoint& stage, Vec a, Vec q) const {
  check(VecWAXPY(q, stage.dt, stage.v0, stage.q0));
  check(VecAXPY(q, stage.dt * stage.dt, a));
}

void Stepper::continue_velocity(const StagePoint& stage, Vec a) const {
  const History& history = *history_;
  std::array<double, num_states(Guess::predicted)> times{};
  const auto num_known = std::min<std::size_t>(times.size(), static_cast<std::size_t>(history.size()));
  for (std::size_t r = 0; r < num_known; ++r) times[r] = history[static_cast<int>(r)].time;
  const auto known = std::span(times).first(num_known);
  const auto used = known.first(num_extrapolated(known, stage.time));
  check(VecZeroEntries(a));
  if (used.size() == 1) return;
  for (std::size_t r = 0; r < used.size(); ++r) {
    check(VecAXPY(a, extrapolation_weight(used, r, stage.time), history[static_cast<int>(r)].v.get()));
  }
  check(VecAXPY(a, -1.0, stage.v0));
  check(VecScale(a, 1.0 / stage.dt));
}

// v_i = (q_i - q_i0) / dt_i, a_i = (v_i - v_i0) / dt_i where it is needed, z_i, and Y_i - y*
void Stepper::end_stage() {
  const std::size_t i = number_++;
  const StagePoint& stage = stage_;
  const Vec rate = system_.space ? rate_.get() : v_.stage();
  check(VecWAXPY(rate, -1.0, stage.q0, q_.stage()));
  check(VecScale(rate, 1.0 / stage.dt));
  if (system_.space) system_.space->velocity(q_.stage(), rate, v_.stage());
  if (z_) system_.internal.end_stage(stage, q_.stage(), z_->stage());
  if (i + 1 == method_.b.size() || !w_.empty() || predictor_) {
    check(VecWAXPY(a_.get(), -1.0, stage.v0, v_.stage()));
    check(VecScale(a_.get(), 1.0 / stage.dt));
  }
  if (!w_.empty()) system_.quadratures.rates(stage, q_.stage(), v_.stage(), a_.get(), rates_);
  for (std::size_t m = 0; m < w_.size(); ++m) w_[m] += weight_.beta * step_.dt * method_.b[i] * rates_[m];
  if (predictor_) predictor_->end_stage(i, a_.get());
  q_.end_stage(i);
  v_.end_stage(i);
  if (z_) z_->end_stage(i);
}

// y_{n+1}
void Stepper::complete_step() {
  const State& newest = history_->newest();
  q_.complete_step(method_.bt);
  v_.complete_step(method_.bt);
  if (system_.space) system_.space->retract(newest.q.get(), q_.end(), end_q_.get());
  const Vec end_q = system_.space ? end_q_.get() : q_.end();
  system_.motion.complete_step(step_, end_q, v_.end());
  if (z_) {
    z_->complete_step(method_.bt);
    system_.internal.complete_step(newest.z.get(), end_q, z_->end());
  }
  for (std::size_t m = 0; m < w_.size(); ++m) w_[m] += newest.w[m];
}

void Stepper::embedded_difference(Vec q, Vec v) const {
  assert(!embedded_.empty());
  q_.combine_increments(embedded_, q);
  v_.combine_increments(embedded_, v);
}

void accept(const StepAttempt& attempt, History& history) {
  assert(attempt.report.outcome == StageOutcome::converged);
  history.push(attempt.view());
}

}  // namespace pliant
