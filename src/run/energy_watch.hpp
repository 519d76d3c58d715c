/// Detects a run with more energy than was supplied, or with much less: the steps are too long for the method.
#pragma once

#include "run/ledger.hpp"

#include <algorithm>
#include <optional>

namespace pliant {

/// Follows the ledger of a motion from the start.
///
///     supplied = T(0) + U(0) + load work - (V - V(0)),   created = T + U - supplied
///
/// where V is the potential of constant loads. With dissipation added, `created` is the ledger's numerical dissipation
/// with the opposite sign. Energy that a method creates and a viscosity dissipates at once does not grow; but if there
/// is much of it, the dissipation in the ledger is wrong. The largest created energy is compared with the largest
/// supplied energy: while loads grow from zero, truncation errors may temporarily be as large as the energy supplied.
class EnergyWatch {
 public:
  /// A larger fraction of the energy supplied than this is not a truncation error [1].
  static constexpr double tolerance = 0.1;
  /// Likewise with dissipation added.
  static constexpr double tolerance_with_dissipation = 0.5;

  struct Growth {
    double factor = 1.0;                ///< (supplied + created) / supplied
    double time = 0.0;                  ///< when the most energy had been created [s]
    bool includes_dissipation = false;  ///< with dissipation added, without which there is no growth
  };

  /// A larger fraction of the energy supplied than this is seen in the motion if the method dissipates it [1].
  static constexpr double tolerated_loss = 0.25;
  struct Loss {
    double dissipated = 0.0;  ///< by the method, since the start [J]
    double supplied = 0.0;    ///< the largest so far [J]
    double share() const { return dissipated / supplied; }
  };

  /// Starts from the initial state.
  explicit EnergyWatch(const Energies& start)
      : start_(start.kinetic + start.elastic + start.load_potential), supplied_(start.kinetic + start.elastic) {}

  /// Examines the end of a step. `rounding`: the energy of rounding errors there
  /// (IncrementalPotential::rounding_energy) [J].
  void look(const Energies& energies, double time, double rounding = 0.0);
  /// Whether all energies so far are rounding errors: of bodies at rest, without loads.
  bool sees_only_rounding() const {
    return std::max({supplied_, created_, created_with_dissipation_}) <= safety * rounding_;
  }
  /// nullopt if no energy was created.
  std::optional<Growth> growth() const;
  /// nullopt if the method has dissipated little. `end`: at the last step examined.
  std::optional<Loss> loss(const Energies& end) const;
  void keep(Archive& archive);

 private:
  static constexpr double safety = 1e4;  // for what adds up over many steps [1]

  double start_;                                                               // T + U + V [J]
  double supplied_;                                                            // largest so far [J]
  double created_ = 0.0;                                                       // likewise
  double created_at_ = 0.0;                                                    // [s]
  double created_with_dissipation_ = 0.0, created_with_dissipation_at_ = 0.0;  // likewise with dissipation added
  double rounding_ = 0.0;                                                      // largest so far, of this process [J]
};

}  // namespace pliant
