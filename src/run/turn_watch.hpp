/// Watches how far prescribed rotations turn within a step: states show rotations only up to whole turns.
#pragma once

#include "input/config.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The prescribed rotations of rigid parts and the motions of hinges. From one state to the next a body rotates the
/// shortest way: if a step prescribes half a turn or more, it rotates the other way, or not at all, and the twist of a
/// rod is lost. Steps are therefore cut such that they prescribe less.
class TurnWatch {
 public:
  /// Refers to the formulas of `config`.
  explicit TurnWatch(const Config& config);

  /// Why a step is too long, in words that name the rotation; nothing if it is not. `from`, `to`: the step's ends,
  /// times [s] or, in a static problem, load factors.
  /// A jump within the step, which no shorter step could follow, is not too long; `accept` names it.
  std::optional<std::string> too_far(double from, double to) const;
  /// Takes the step as accepted. In words, which rotation has jumped by half a turn or more, at the step's start since
  /// the step before, or within it.
  std::optional<std::string> accept(double from, double to);
  /// The next step follows none.
  void forget();

 private:
  struct Rotation {
    std::string name;
    const Expression* angle = nullptr;  // [rad]
    std::optional<double> last;         // at the end of the last step [rad]
  };
  double angle_at(const Rotation& rotation, double at) const;
  /// Where it jumps by half a turn or more between two times, as far as samples show.
  std::optional<double> jump(const Rotation& rotation, double from, double to) const;

  std::optional<double> static_time_;  // at which formulas of a static problem are evaluated [s]
  std::vector<Rotation> rotations_;
};

}  // namespace pliant
