/// Viscosity of rods.
#pragma once

#include "energy/rod/rods.hpp"

namespace pliant {

/// Resists the rates of all strains of rods in proportion to their stiffness: with the rates s' = ds/dx . x' at the end
/// of the stage, x' = (x - x0)/dt, the forces are sum_k beta c_k s_k' ds_k/dx, without a potential. The rate (s -
/// s0)/dt would have one, and the first order for every method (docs/theory.md, "Strain rates and their orders"). The
/// Hessian, beta c (ds/dx (ds/dx / dt + d2s/dx2 x')^T + s' d2s/dx2), is unsymmetric.
class RodViscosity final : public EnergyTerm {
 public:
  /// `rods` outlives the object.
  explicit RodViscosity(const Rods& rods) : rods_(rods) {}

  std::string_view name() const override { return "rod-viscosity"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return rods_.coupling(); }
  double value(const LocalStage& /*stage*/, std::span<const double> /*q*/) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;

 private:
  /// Calls visit(stencil, is_counted) for each segment and vertex that has a resistance, with that resistance as the
  /// stiffness of the stencil.
  template <int order, class Visit>
  void for_each(const LocalStage& stage, std::span<const double> q, const Visit& visit) const;

  const Rods& rods_;
};

}  // namespace pliant
