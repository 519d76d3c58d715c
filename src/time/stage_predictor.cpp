#include "time/stage_predictor.hpp"

#include "time/extrapolation.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

namespace pliant {
namespace {

WorkVector vector_like(Vec like) {
  return WorkVector([like] {
    Handle<Vec> vector;
    check(VecDuplicate(like, vector.out()));
    return vector;
  });
}

}  // namespace

StagePredictor::StagePredictor(int num_stages, Vec like)
    : stages_(static_cast<std::size_t>(num_stages)),
      missed_(vector_like(like)),
      polynomial_(vector_like(like)),
      caller_(vector_like(like)) {
  for (Stage& stage : stages_) {
    for (std::size_t r = 0; r <= depth; ++r) stage.a.push_back(vector_like(like));
  }
}

void StagePredictor::begin() {
  num_ended_ = 0;
}

void StagePredictor::extrapolate(const Stage& stage, double time) {
  const auto past = std::span(stage.times).subspan(1, stage.num_past);
  const auto used = past.first(num_extrapolated(past, time));
  check(VecZeroEntries(polynomial_.get()));
  for (std::size_t r = 0; r < used.size(); ++r) {
    check(VecAXPY(polynomial_.get(), extrapolation_weight(used, r, time), stage.a[r + 1].get()));
  }
}

void StagePredictor::predict(std::size_t number, double time, Vec a) {
  Stage& stage = stages_[number];
  stage.times[0] = time;
  has_polynomial_ = stage.num_past > 0;
  is_by_polynomial_ = false;
  if (!has_polynomial_) return;
  extrapolate(stage, time);
  check(VecCopy(a, caller_.get()));
  const Lesson& lesson = stage.accepted;
  if (!lesson.is_known || !(lesson.error_of_polynomial < lesson.error_of_caller)) return;
  is_by_polynomial_ = true;
  check(VecCopy(polynomial_.get(), a));
  if (number > 0) check(VecAXPY(a, 1.0, missed_.get()));
}

bool StagePredictor::withdraw(Vec a) {
  if (!is_by_polynomial_) return false;
  has_polynomial_ = is_by_polynomial_ = false;
  forget();
  check(VecCopy(caller_.get(), a));
  return true;
}

void StagePredictor::end_stage(std::size_t number, Vec a) {
  Stage& stage = stages_[number];
  num_ended_ = number + 1;
  check(VecCopy(a, stage.a[0].get()));
  stage.tried = {};
  if (!has_polynomial_) return;
  stage.tried.is_known = true;
  check(VecAXPY(caller_.get(), -1.0, a));
  check(VecNorm(caller_.get(), NORM_2, &stage.tried.error_of_caller));
  check(VecAYPX(polynomial_.get(), -1.0, a));  // what it missed
  check(VecCopy(polynomial_.get(), caller_.get()));
  if (number > 0) check(VecAXPY(caller_.get(), -1.0, missed_.get()));
  check(VecNorm(caller_.get(), NORM_2, &stage.tried.error_of_polynomial));
  if (stages_.size() > 1) std::swap(missed_, polynomial_);
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
  forget();
}

void StagePredictor::forget() {
  for (Stage& stage : stages_) {
    stage.num_past = 0;
    stage.tried = stage.accepted = {};
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
    archive.number("is_known", lesson.is_known);
    archive.number("error_of_polynomial", lesson.error_of_polynomial);
    archive.number("error_of_caller", lesson.error_of_caller);
  }
}

}  // namespace pliant
