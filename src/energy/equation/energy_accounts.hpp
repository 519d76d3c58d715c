/// Energies, powers and stresses of the terms of a potential: for ledgers and results, not for solvers.
#pragma once

#include "energy/equation/stage_terms.hpp"
#include "energy/stress.hpp"

#include <array>
#include <functional>
#include <initializer_list>
#include <vector>

namespace pliant {

/// What the forces of a term do, over all ranks: numbers of one kind, which are summed as they are stored.
struct TermPower {
  static constexpr std::size_t num_numbers = 6;
  double exerted = 0.0;     ///< by its forces, -dPhi_k/dq . v summed over all entries, prescribed ones included [W]
  double dissipated = 0.0;  ///< EnergyTerm::dissipation [W]
  double supplied = 0.0;    ///< EnergyTerm::supply [W]
  std::array<double, 3> force{};  ///< sum of its forces -dPhi_k/dq over the nodes of EnergyTerm::is_measured_at [N]
};

/// A view of terms; all methods are collective.
class EnergyAccounts {
 public:
  explicit EnergyAccounts(StageTerms& terms) : terms_(terms) {}

  /// r = the gradient of the potential of the stage with the reactions on prescribed entries; returns what the forces
  /// of each term do at the velocity v.
  std::vector<TermPower> powers(Vec q, Vec v, Vec r);
  /// EnergyTerm::energy_at of each term whose account is `stored` or `load_potential`, 0 for the others; z may be
  /// nullptr without internal variables [J].
  std::vector<double> energies(const Instant& when, Vec q, Vec z);
  /// EnergyTerm::dissipated of each term; z as above [J].
  std::vector<double> dissipated(Vec z) const;
  /// Which terms count: TermDeclaration::has_moving_obstacle.
  enum class MovingObstacles { left_out, alone };
  /// Change of the energies at fixed q from one instant to another, which time alone causes [J].
  double supplied(const Instant& from, const Instant& to, Vec q, MovingObstacles which);
  /// The sum of the energies that each term which `has_load_energy` has at two instants, 0 for the others [J].
  std::vector<double> load_energies(const Instant& one, const Instant& other, Vec q);
  /// Calls `visit` for the stress that each term has in each of its local cells, ghosts included; z as above, v =
  /// nullptr: at rest.
  void visit_stresses(const Instant& at, Vec q, Vec v, Vec z,
                      const std::function<void(StressPart, PetscInt, const CellStress&)>& visit);

  /// The state as one of the terms sees it; valid until the next call of any method. z and v as above.
  BodyState state_of(const EnergyTerm& term, const Instant& at, Vec q, Vec v, Vec z);

 private:
  struct Weighted {
    Instant when;
    double weight = 1.0;
  };
  using Wanted = std::function<bool(const TermDeclaration&)>;
  /// The weighted sum of the energies at q of each term wanted, 0 for the others.
  std::vector<double> sums_of_energies(const Wanted& wanted, std::initializer_list<Weighted> instants, Vec q,
                                       Vec z = nullptr);

  StageTerms& terms_;
};

}  // namespace pliant
