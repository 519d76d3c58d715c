/// Viscosity of the bending of thin layers.
#pragma once

#include "energy/shell/shell_bending.hpp"

#include <span>
#include <string_view>

namespace pliant {

/// Resistances to the rate of curvature: moments (damping D nu + trace) tr(k') I + (damping D (1 - nu) + shear) k', D
/// and nu those of the layer's bending.
struct BendingResistance {
  double damping = 0.0;  ///< viscous resistance per stiffness [s]
  double trace = 0.0;    ///< [N m s]
  double shear = 0.0;    ///< [N m s]
};

/// With the rates k' = sum_h G_h theta_h', theta' = dtheta/dx . (x - x0)/dt at the end of the stage, the forces are
/// sum_h A (G_h . m(k')) dtheta_h/dx, without a potential, so that every method keeps its order (docs/theory.md,
/// "Strain rates and their orders"). The Hessian is unsymmetric.
class ShellBendingViscosity final : public EnergyTerm {
 public:
  /// `bending` outlives the object.
  ShellBendingViscosity(const ShellBending& bending, const BendingResistance& resistance)
      : bending_(bending), resistance_(resistance) {}

  std::string_view name() const override { return "shell-viscosity"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return bending_.coupling(); }
  double value(const LocalStage& /*stage*/, std::span<const double> /*q*/) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;

 private:
  /// The moment of a rate of curvature (xx, yy, 2 xy), per length [N].
  std::array<double, 3> moment(const BendingStencil& stencil, const std::array<double, 3>& rate) const;

  const ShellBending& bending_;
  BendingResistance resistance_;
};

}  // namespace pliant
