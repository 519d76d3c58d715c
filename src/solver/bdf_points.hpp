/// What PETSc's TSBDF remembers of earlier steps. It keeps that to itself; recorded here as it arises, it can be given
/// to a TSBDF that starts anew.
#pragma once

#include "time/state.hpp"

#include <cstddef>
#include <vector>

namespace pliant {

/// The points that TSBDF lays its polynomials through, in the order in which it got them. A start gives it two: the
/// middle of the first step, for which it solves, then the state it starts from. The end of each step follows.
class BdfPoints {
 public:
  /// As many as a method of this order looks at in its next step, and one more, which takes the place of the middle of
  /// a first step.
  explicit BdfPoints(int order) : capacity_(static_cast<std::size_t>(order) + 2) {}

  /// Appends a copy; the oldest makes room for it. Collective.
  void push(const StateView& point);
  void forget() { size_ = 0; }
  /// Vectors are made like those of `like`. Collective.
  void keep(Archive& archive, const StateView& like);

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  /// The oldest has the number 0.
  const State& operator[](std::size_t i) const { return points_[i]; }

 private:
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::vector<State> points_;  // beyond size_: memory for later
};

}  // namespace pliant
