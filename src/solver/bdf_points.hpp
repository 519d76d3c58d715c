/// The history of PETSc's TSBDF. TSBDF does not expose it; it is recorded here as it arises, and can be handed to a
/// TSBDF that starts anew.
#pragma once

#include "time/state.hpp"

#include <cstddef>
#include <vector>

namespace pliant {

/// The points that TSBDF interpolates, in the order in which it received them. At the start it receives two: the middle
/// of the first step, for which it solves, then the initial state. The end of each step follows.
class BdfPoints {
 public:
  /// Holds as many points as a method of this order needs for its next step, and one more, which replaces the middle of
  /// a first step.
  explicit BdfPoints(int order) : capacity_(static_cast<std::size_t>(order) + 2) {}

  /// Appends a copy, and drops the oldest point if all are in use. Collective.
  void push(const StateView& point);
  void forget() { size_ = 0; }
  /// Vectors are made like those of `like`. Collective.
  void keep(Archive& archive, const StateView& like);

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  /// Point 0 is the oldest.
  const State& operator[](std::size_t i) const { return points_[i]; }

 private:
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::vector<State> points_;  // allocated beyond size_, for later use
};

}  // namespace pliant
