/// Inertia: 1/(2 dt^2) |q - q0 - dt v0|_M^2.
#pragma once

#include "energy/term.hpp"
#include "fem/cells.hpp"

#include <array>
#include <memory>
#include <vector>

namespace pliant {

enum class Mass { consistent, lumped };

/// Momenta of a state, summed over this rank's nodes.
struct Momenta {
  std::array<double, 3> linear{};   ///< [kg m/s]
  std::array<double, 3> angular{};  ///< about the origin [kg m^2/s]
};

/// A scalar mass per pair of nodes that share a cell, assembled once; it acts on each component alike.
class Inertia final : public EnergyTerm {
 public:
  /// `diagonal`, `off_diagonal`: masses of the pattern's blocks of owned and of other columns [kg]. The pattern
  /// outlives the term.
  Inertia(const NodeLayout& layout, const BlockPattern& pattern, std::vector<double> diagonal,
          std::vector<double> off_diagonal);

  std::string_view name() const override { return "inertia"; }
  TermDeclaration declaration() const override { return {.account = Account::kinetic}; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;

  /// y += M x on rows of owned nodes [x unit * kg]. Not collective.
  void add_mass_times(std::span<const double> x, std::span<double> y) const;
  /// 1/2 v . M v of the owned nodes [J].
  double kinetic_energy(std::span<const double> v) const;
  /// Of this rank's owned nodes; `X` are the reference coordinates of the local nodes.
  Momenta momenta(std::span<const double> X, std::span<const double> q, std::span<const double> v) const;
  /// This rank's share of the mass [kg].
  double total_mass() const;

 private:
  struct Part {
    const BlockPattern::Rows* rows;
    std::vector<double> masses;  // per block [kg]
  };
  PetscInt num_owned_nodes_;
  PetscInt num_local_nodes_;
  Part diagonal_;
  Part off_diagonal_;
};

/// `densities`: per body [kg/m^3]. The consistent mass is integrated exactly on affine cells, on curved ones to the
/// degree of their mapping; the lumped mass distributes each cell's mass in proportion to the diagonal of its
/// consistent matrix (Hinton, Rock & Zienkiewicz 1976), so that it stays positive for P2. `pattern` outlives the term.
template <int Order>
std::unique_ptr<Inertia> make_inertia(const NodeLayout& layout, const BlockPattern& pattern,
                                      const CellGroups<Order>& groups, const std::vector<double>& densities, Mass mass);

/// int density N_a dX per owned node [kg], 0 in ghost places. Not collective.
template <int Order>
std::vector<double> nodal_masses(const NodeLayout& layout, const CellGroups<Order>& groups,
                                 const std::vector<double>& densities);

}  // namespace pliant
