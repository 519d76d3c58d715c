#include "time/stage_predictor.hpp"

#include "base/cholesky.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace pliant {
namespace {

/// A polynomial is not continued farther than this, in mean lengths of the past steps.
constexpr double max_extrapolation = 2.0;
/// How much of the square of the past accelerations a coefficient must explain to leave that of the polynomial.
constexpr double ridge = 1e-10;

}  // namespace

StagePredictor::StagePredictor(int num_stages, Vec like) : stages_(static_cast<std::size_t>(num_stages)) {
  for (Stage& stage : stages_) {
    stage.a.resize(depth + 1);
    for (Handle<Vec>& a : stage.a) check(VecDuplicate(like, a.out()));
  }
  for (Handle<Vec>* x : {&missed_, &regression_, &caller_}) check(VecDuplicate(like, x->out()));
}

void StagePredictor::begin() {
  num_ended_ = 0;
}

std::size_t StagePredictor::num_usable(const Stage& stage, double time) const {
  const auto& t = stage.times;
  std::size_t n = stage.num_past;
  while (n > 1 && time - t[1] > max_extrapolation * (t[1] - t[n]) / static_cast<double>(n - 1)) --n;
  return n;
}

StagePredictor::Coefficients StagePredictor::polynomial(const Stage& stage, std::size_t num_past, double time) {
  const auto& t = stage.times;
  Coefficients c{};
  for (std::size_t r = 0; r < num_past; ++r) {
    c[r] = 1.0;
    for (std::size_t k = 0; k < num_past; ++k) {
      if (k != r) c[r] *= (time - t[k + 1]) / (t[r + 1] - t[k + 1]);
    }
  }
  return c;
}

std::span<const Vec> StagePredictor::past(std::size_t stage, std::size_t num_past) {
  for (std::size_t r = 0; r < num_past; ++r) borrowed_[r] = stages_[stage].a[r + 1].get();
  return std::span(borrowed_).first(num_past);
}

void StagePredictor::predict(std::size_t number, double time, Vec a) {
  Stage& stage = stages_[number];
  stage.times[0] = time;
  num_used_ = num_usable(stage, time);
  if (num_used_ == 0) return;
  prior_ = polynomial(stage, num_used_, time);
  const Lesson& lesson = stage.accepted;
  Coefficients c = prior_;
  if (lesson.num_past == num_used_) {
    for (std::size_t k = 0; k < num_used_; ++k) c[k] += lesson.coefficients[k];
  }
  const auto x = past(number, num_used_);
  check(VecZeroEntries(regression_.get()));
  check(VecMAXPY(regression_.get(), static_cast<PetscInt>(x.size()), c.data(), const_cast<Vec*>(x.data())));
  check(VecCopy(a, caller_.get()));
  if (lesson.num_past == 0 || !(lesson.error_of_regression < lesson.error_of_caller)) return;
  check(VecCopy(regression_.get(), a));
  if (number > 0) check(VecAXPY(a, 1.0, missed_.get()));
}

void StagePredictor::end_stage(std::size_t number, Vec a) {
  Stage& stage = stages_[number];
  num_ended_ = number + 1;
  check(VecCopy(a, stage.a[0].get()));
  stage.tried = {};
  if (num_used_ == 0) return;
  stage.tried.num_past = num_used_;
  stage.tried.coefficients = fit(past(number, num_used_), prior_, a);
  check(VecAXPY(caller_.get(), -1.0, a));
  check(VecNorm(caller_.get(), NORM_2, &stage.tried.error_of_caller));
  check(VecAYPX(regression_.get(), -1.0, a));  // what it missed
  check(VecCopy(regression_.get(), caller_.get()));
  if (number > 0) check(VecAXPY(caller_.get(), -1.0, missed_.get()));
  check(VecNorm(caller_.get(), NORM_2, &stage.tried.error_of_regression));
  std::swap(missed_, regression_);
}

StagePredictor::Coefficients StagePredictor::fit(std::span<const Vec> past, const Coefficients& prior, Vec a) {
  const std::size_t n = past.size();
  SmallMatrix<depth> G{};
  Coefficients change{};
  double trace = 0.0;
  for (std::size_t r = 0; r < n; ++r) {
    check(VecMDot(past[r], static_cast<PetscInt>(n), past.data(), G[r].data()));
    check(VecDot(a, past[r], &change[r]));
    trace += G[r][r];
  }
  if (!(trace > 0.0)) return {};
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t k = 0; k < n; ++k) change[r] -= G[r][k] * prior[k];
  }
  for (std::size_t r = 0; r < n; ++r) G[r][r] += ridge * trace;
  factorize_by_cholesky(G, n);
  solve_by_cholesky(G, std::span(change).first(n));
  return change;
}

void StagePredictor::accept() {
  if (num_ended_ < stages_.size()) return restart();
  num_ended_ = 0;
  for (Stage& stage : stages_) {
    std::ranges::rotate(stage.a, stage.a.end() - 1);
    std::ranges::rotate(stage.times, stage.times.end() - 1);
    stage.num_past = std::min(stage.num_past + 1, depth);
    stage.accepted = stage.tried;
  }
}

void StagePredictor::restart() {
  num_ended_ = 0;
  for (Stage& stage : stages_) {
    stage.num_past = 0;
    stage.accepted = {};
  }
}

void StagePredictor::keep(Archive& archive) {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const Archive::Section section(archive, std::to_string(i));
    Stage& stage = stages_[i];
    archive.number("num_past", stage.num_past);
    archive.numbers("times", stage.times);
    for (std::size_t r = 1; r <= stage.num_past; ++r) {
      archive.vector("a" + std::to_string(r), Entries::nodes, stage.a[r].get());
    }
    Lesson& lesson = stage.accepted;
    archive.number("num_fitted", lesson.num_past);
    archive.numbers("coefficients", lesson.coefficients);
    archive.number("error_of_regression", lesson.error_of_regression);
    archive.number("error_of_caller", lesson.error_of_caller);
  }
}

}  // namespace pliant
