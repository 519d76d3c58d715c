/// States y = (q, v, z, w) of the motion: configuration, velocity, internal variables (time/stage.hpp) and quadratures.
#pragma once

#include "petsc/archive.hpp"
#include "petsc/handle.hpp"

#include <span>
#include <vector>

namespace pliant {

/// A state whose vectors another object owns.
struct StateView {
  double time = 0.0;               ///< [s]
  Vec q = nullptr;                 ///< configuration [m]
  Vec v = nullptr;                 ///< velocity [m/s]
  Vec z = nullptr;                 ///< internal variables; nullptr if there are none
  std::span<const double> w = {};  ///< quadratures, the same numbers on every rank; empty if there are none
  double load_factor = 1.0;        ///< StagePoint::load_factor, at which a static problem has this state
};

struct State {
  double time = 0.0;      ///< [s]
  Handle<Vec> q;          ///< configuration [m]
  Handle<Vec> v;          ///< velocity [m/s]
  Handle<Vec> z;          ///< internal variables; null if there are none
  std::vector<double> w;  ///< quadratures

  State() = default;
  /// A copy. Collective.
  explicit State(const StateView& state);
  /// Copies a state of the same layout; allocates nothing. Collective.
  void assign(const StateView& state);
  /// Collective.
  void keep(Archive& archive);
  StateView view() const { return {time, q.get(), v.get(), z.get(), w}; }
};

/// The last accepted states, newest first. Only accepted steps are pushed; the vectors belong to the history, and
/// others only read them. Memory is allocated once, at construction.
class History {
 public:
  /// Holds up to `depth` >= 1 states; begins with a copy of the given one. Collective.
  History(int depth, const StateView& initial);

  /// Pushes a copy as the newest state and drops the oldest if the history is full. Collective.
  void push(const StateView& state);
  /// Forgets all states but the newest. The motion after it does not continue the one before: the velocity of the state
  /// returned may be changed.
  State& restart();
  /// Quadratures of the newest state.
  void set_quadratures(std::span<const double> w);
  /// Adds to the quadratures of all states, as if `change` had been there from the start.
  void shift_quadratures(std::span<const double> change);

  /// Collective.
  void keep(Archive& archive);

  /// The state `age` steps before the newest, 0 <= age < size().
  const State& operator[](int age) const;
  const State& newest() const { return (*this)[0]; }
  int size() const { return size_; }
  int depth() const { return static_cast<int>(states_.size()); }

 private:
  std::vector<State> states_;
  int size_ = 0;
};

}  // namespace pliant
