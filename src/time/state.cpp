#include "time/state.hpp"

#include <algorithm>
#include <cassert>
#include <functional>
#include <string>

namespace pliant {

State::State(const StateView& state) : w(state.w.size()) {
  check(VecDuplicate(state.q, q.out()));
  check(VecDuplicate(state.v, v.out()));
  if (state.z != nullptr) check(VecDuplicate(state.z, z.out()));
  assign(state);
}

void State::assign(const StateView& state) {
  assert(w.size() == state.w.size() && (z.get() == nullptr) == (state.z == nullptr));
  time = state.time;
  check(VecCopy(state.q, q.get()));
  check(VecCopy(state.v, v.get()));
  if (state.z != nullptr) check(VecCopy(state.z, z.get()));
  std::ranges::copy(state.w, w.begin());
}

void State::keep(Archive& archive) {
  archive.number("time", time);
  archive.vector("q", Entries::nodes, q.get());
  archive.vector("v", Entries::nodes, v.get());
  if (z) archive.vector("z", Entries::internal, z.get());
  if (!w.empty()) archive.numbers("w", w);
}

History::History(int depth, const StateView& initial) : size_(1) {
  assert(depth >= 1);
  for (int age = 0; age < depth; ++age) states_.emplace_back(initial);
}

void History::push(const StateView& state) {
  assert(state.time > newest().time);
  std::rotate(states_.begin(), states_.end() - 1, states_.end());
  states_.front().assign(state);
  size_ = std::min(size_ + 1, depth());
}

State& History::restart() {
  size_ = 1;
  return states_.front();
}

void History::set_quadratures(std::span<const double> w) {
  assert(w.size() == states_.front().w.size());
  std::ranges::copy(w, states_.front().w.begin());
}

void History::shift_quadratures(std::span<const double> change) {
  assert(change.size() == states_.front().w.size());
  for (State& state : states_) std::ranges::transform(state.w, change, state.w.begin(), std::plus{});
}

void History::keep(Archive& archive) {
  archive.number("size", size_);
  for (int age = 0; age < size_; ++age) {
    const Archive::Section section(archive, std::to_string(age));
    states_.at(static_cast<std::size_t>(age)).keep(archive);
  }
}

const State& History::operator[](int age) const {
  assert(age >= 0 && age < size_);
  return states_[static_cast<std::size_t>(age)];
}

}  // namespace pliant
