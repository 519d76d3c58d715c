/// Energies, powers and stresses of the terms of a potential: for ledgers and results, not for solvers.
#pragma once

#include "energy/equation/stage_terms.hpp"
#include "energy/stress.hpp"

#include <array>
#include <functional>
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
  /// EnergyTerm::energy_at of each term; z may be nullptr if there are no internal variables [J].
  std::vector<double> energies(const Instant& when, Vec q, Vec z);
  /// EnergyTerm::dissipated of each term; z as above [J].
  std::vector<double> dissipated(Vec z) const;
  /// Which terms count: walls (TermDeclaration::is_wall) may have infinite energies where they stand later.
  enum class Walls { left_out, alone };
  /// Change of the energies at fixed q from one instant to another, which time alone causes [J].
  double supplied(const Instant& from, const Instant& to, Vec q, Walls walls);
  /// Calls `visit` for the stress that each term has in each of its local cells, ghosts included; z as above, v =
  /// nullptr: at rest.
  void visit_stresses(const Instant& at, Vec q, Vec v, Vec z,
                      const std::function<void(StressPart, PetscInt, const CellStress&)>& visit);

  /// The state as one of the terms sees it; valid until the next call of any method. z and v as above.
  BodyState state_of(const EnergyTerm& term, const Instant& at, Vec q, Vec v, Vec z);

 private:
  StageTerms& terms_;
};

}  // namespace pliant
