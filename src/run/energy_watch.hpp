/// Whether a run has more energy than came in: the sign of a method that cannot take the steps it is given.
#pragma once

#include "run/ledger.hpp"

#include <optional>

namespace pliant {

/// Follows the ledger of a motion from the start.
///
///     came in = T(0) + U(0) + load work - (V - V(0)),   made = T + U - came in
///
/// where V is the potential of constant loads. With what was dissipated, `made` is what the ledger calls numerical
/// dissipation, with the other sign: what a method makes and a viscosity takes at once does not grow, but where it is
/// much the books of the dissipation are wrong. The most that was made is compared with the most that came
/// in: while loads grow from zero, errors of truncation may for a moment be as large as what came in by then.
class EnergyWatch {
 public:
  /// A larger part than this of what came in is not an error of truncation [1].
  static constexpr double tolerance = 0.1;
  /// The same with what was dissipated.
  static constexpr double tolerance_in_all = 0.5;

  struct Growth {
    double factor = 1.0;     ///< (came in + made) / came in
    double time = 0.0;       ///< when most was made [s]
    bool is_in_all = false;  ///< with what was dissipated, as else there is no growth
  };

  /// The initial state.
  explicit EnergyWatch(const Energies& start)
      : start_(start.kinetic + start.elastic + start.load_potential), came_in_(start.kinetic + start.elastic) {}

  /// The end of a step.
  void look(const Energies& energies, double time);
  /// Nothing where no energy was made.
  std::optional<Growth> growth() const;
  void keep(Archive& archive);

 private:
  double start_;                                     // T + U + V [J]
  double came_in_;                                   // the most so far [J]
  double made_ = 0.0;                                // likewise
  double made_at_ = 0.0;                             // [s]
  double made_in_all_ = 0.0, made_in_all_at_ = 0.0;  // the same with what was dissipated
};

}  // namespace pliant
