/// Inertia: 1/(2 dt^2) |q - q0 - dt v0|_M^2.
#pragma once

#include "energy/term.hpp"
#include "energy/volume/mass_matrix.hpp"

#include <array>
#include <memory>
#include <vector>

namespace pliant {

/// Momenta of a state, summed over this rank's nodes.
struct Momenta {
  std::array<double, 3> linear{};   ///< [kg m/s]
  std::array<double, 3> angular{};  ///< about the origin [kg m^2/s]
};

class Inertia final : public EnergyTerm {
 public:
  /// `of_cells`: the part of the mass that cells have.
  Inertia(const NodeLayout& layout, MassMatrix mass, CellMassProducts of_cells)
      : num_owned_nodes_(layout.num_owned_nodes), mass_(std::move(mass)), of_cells_(std::move(of_cells)) {}

  std::string_view name() const override { return "inertia"; }
  TermDeclaration declaration() const override { return {.account = Account::kinetic}; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  bool set_hessian(const LocalStage& stage, const BlockWriter& K) const override;
  bool has_adjoint() const override { return true; }
  void pull_back(const LocalStage& stage, std::span<const double> q, const StageMultipliers& m,
                 const StageSlopes& slopes) const override;

  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override;

  const MassMatrix& mass() const { return mass_; }
  /// 1/2 v . M v of the owned nodes [J].
  double kinetic_energy(std::span<const double> v) const { return 0.5 * mass_.product(v, v); }
  /// The owned nodes of this rank; `X` are the reference coordinates of the local nodes.
  Momenta momenta(std::span<const double> X, std::span<const double> q, std::span<const double> v) const;

 private:
  static std::vector<double> acceleration(const LocalStage& stage, std::span<const double> q);

  PetscInt num_owned_nodes_;
  MassMatrix mass_;
  CellMassProducts of_cells_;
};

/// `densities`: per body [kg/m^3]. `pattern` must outlive the term.
template <int Order>
std::unique_ptr<Inertia> make_inertia(const NodeLayout& layout, const BlockPattern& pattern,
                                      const CellGroups<Order>& groups, const std::vector<double>& densities, Mass mass);

}  // namespace pliant
