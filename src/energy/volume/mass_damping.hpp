/// Damping proportional to mass: R = alpha/2 rho v.v per reference volume.
///
/// With v = (q - q0)/dt in a stage, which every method integrates to its order,
///
///     Phi(q) = 1/(2 dt) (q - q0) . B (q - q0)
///     force = -B v,  dissipation = v . B v,   B_ab = int alpha rho N_a N_b dX
///
/// A rigid motion is damped like any other. Source: Rayleigh, The Theory of Sound (1894), section 81.
#pragma once

#include "energy/term.hpp"
#include "energy/volume/mass_matrix.hpp"
#include "material/viscosity.hpp"

namespace pliant {

class MassDamping final : public EnergyTerm {
 public:
  /// `matrix`: B, the mass matrix of the densities alpha rho [kg/s]; `of_cells`: its parts.
  MassDamping(MassMatrix matrix, CellMassProducts of_cells)
      : matrix_(std::move(matrix)), of_cells_(std::move(of_cells)) {}

  std::string_view name() const override { return MassProportional::name; }
  TermDeclaration declaration() const override { return {.dissipates = true}; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  bool has_adjoint() const override { return true; }
  void pull_back(const LocalStage& stage, std::span<const double> q, const StageMultipliers& m,
                 const StageSlopes& slopes) const override;
  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;

 private:
  MassMatrix matrix_;
  CellMassProducts of_cells_;
};

}  // namespace pliant
