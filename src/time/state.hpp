/// Accepted states of the motion.
#pragma once

#include "petsc/handle.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

namespace pliant {

struct State {
  double time = 0.0;  ///< [s]
  Handle<Vec> q;      ///< configuration [m]
  Handle<Vec> v;      ///< velocity [m/s]
};

/// The last accepted states, newest first. Only `push` changes it, and only an accepted step is pushed; the vectors are
/// the history's own and are read by others, never written. Memory is taken once, at construction.
class History {
 public:
  /// Holds up to `depth` states, at present the one given, which is copied. Collective.
  History(int depth, double time, Vec q, Vec v) : states_(static_cast<std::size_t>(depth)) {
    assert(depth >= 1);
    for (auto& state : states_) {
      check(VecDuplicate(q, state.q.out()));
      check(VecDuplicate(v, state.v.out()));
    }
    push(time, q, v);
  }

  /// Makes a copy of (time, q, v) the newest state and forgets the oldest if all places are taken. Collective.
  void push(double time, Vec q, Vec v) {
    assert(size_ == 0 || time > states_.front().time);
    std::rotate(states_.begin(), states_.end() - 1, states_.end());
    State& newest = states_.front();
    newest.time = time;
    check(VecCopy(q, newest.q.get()));
    check(VecCopy(v, newest.v.get()));
    size_ = std::min(size_ + 1, depth());
  }

  /// The state `age` steps before the newest, 0 <= age < size().
  const State& operator[](int age) const {
    assert(age >= 0 && age < size_);
    return states_[static_cast<std::size_t>(age)];
  }
  const State& newest() const { return (*this)[0]; }
  int size() const { return size_; }
  int depth() const { return static_cast<int>(states_.size()); }

 private:
  std::vector<State> states_;
  int size_ = 0;
};

}  // namespace pliant
