/// Watches how far prescribed rotations turn within a step: states show rotations only up to whole turns.
#pragma once

#include "input/config.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The prescribed rotations of rigid parts and the motions of hinges. Between two states a body turns the shortest way:
/// what a step turns by half a turn or more, it would turn the other way or not at all, and what a rod is twisted by
/// would be lost. So steps turn less.
class TurnWatch {
 public:
  /// Refers to the formulas of `config`.
  explicit TurnWatch(const Config& config);

  /// Why a step is too long, in words that name the rotation; nothing if it is not. `from`, `to`: the step's ends,
  /// times [s] or, in a static problem, load factors.
  std::optional<std::string> too_far(double from, double to) const;
  /// Takes the step as accepted. In words, which rotation has jumped at the step's start by half a turn or more since
  /// the step before.
  std::optional<std::string> accept(double from, double to);

 private:
  struct Rotation {
    std::string name;
    const Expression* angle = nullptr;  // [rad]
    std::optional<double> last;         // at the end of the last step [rad]
  };
  double angle_at(const Rotation& rotation, double at) const;

  std::optional<double> static_time_;  // at which formulas of a static problem are evaluated [s]
  std::vector<Rotation> rotations_;
};

}  // namespace pliant
