#include "study/stage_extrapolation.hpp"

#include "petsc/check.hpp"
#include "solver/merit.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// A guess with a larger error relative to the solution is not worth having.
constexpr double worth_having = 0.5;
/// Places that are closer, relative to their values, are the same.
constexpr double same_place = 1e-9;

}  // namespace

StageExtrapolation::StageExtrapolation(Vec like) {
  check(VecDuplicate(like, trial_.out()));
}

void StageExtrapolation::extrapolate(std::size_t count, double place, Vec x) const {
  std::array<PetscScalar, most> weights{};
  std::array<Vec, most> solutions{};
  for (std::size_t j = 0; j < count; ++j) {
    weights[j] = 1.0;
    for (std::size_t k = 0; k < count; ++k) {
      if (k != j) weights[j] *= (place - known_[k].place) / (known_[j].place - known_[k].place);
    }
    solutions[j] = known_[j].solution.get();
  }
  check(VecZeroEntries(x));
  check(VecMAXPY(x, static_cast<PetscInt>(count), weights.data(), solutions.data()));
}

bool StageExtrapolation::guess(double place, Vec x) const {
  const bool is_known = std::ranges::any_of(
      known_, [&](const Known& k) { return std::abs(k.place - place) <= same_place * std::abs(place); });
  if (count_ == 0 || is_known) {
    check(VecZeroEntries(x));
    return false;
  }
  extrapolate(count_, place, x);
  return true;
}

void StageExtrapolation::take(double place, Vec solution) {
  // A step that is tried again passes the same places.
  std::erase_if(known_, [&](const Known& k) { return std::abs(k.place - place) <= same_place * std::abs(place); });
  double least = worth_having * norm(solution);
  const std::size_t before = count_;
  count_ = 0;
  // The degree changes by one at a time.
  const std::size_t last = std::min(known_.size(), before + 1);
  for (std::size_t count = before > 1 ? before - 1 : 1; count <= last; ++count) {
    extrapolate(count, place, trial_.get());
    check(VecAXPY(trial_.get(), -1.0, solution));
    const double error = norm(trial_.get());
    if (!(error < least)) continue;
    least = error;
    count_ = count;
  }
  Known taken{place, {}};
  if (known_.size() < most) {
    check(VecDuplicate(solution, taken.solution.out()));
  } else {
    taken.solution = std::move(known_.back().solution);
    known_.pop_back();
  }
  check(VecCopy(solution, taken.solution.get()));
  known_.insert(known_.begin(), std::move(taken));
}

}  // namespace pliant
