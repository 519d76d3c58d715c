/// A cavity of the body, filled with a gas or a liquid that exerts a pressure on its walls.
#pragma once

#include "energy/function_of_sum.hpp"
#include "energy/load/cavity_content.hpp"
#include "energy/load/wetted_surface.hpp"

namespace pliant {

/// The term Phi(S) = int p dS of the volume S that the walls have swept (energy/load/cavity_content.hpp,
/// energy/load/wetted_surface.hpp), an exact potential:
///
///     r = p dS,    K = p d2S + p' dS dS^T
///
/// The walls are closed, or their rim does not move.
class Cavity final : public EnergyTerm, public FunctionOfSum {
 public:
  Cavity(WettedSurface walls, CavityContent content) : walls_(std::move(walls)), content_(std::move(content)) {}

  std::string_view name() const override { return "cavity"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return static_cast<const FunctionOfSum*>(this); }
  /// The whole value is in value_of_sum.
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  /// p d2S; nothing if it is to be projected.
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;

  SumOverRanks part(const LocalStage& stage, std::span<const double> q) const override;
  double value_of_sum(const LocalStage& stage) const override;
  double energy_of_sum(const Instant& at, double S) const override;
  double curvature(const LocalStage& stage) const override;
  void add_gradient_of_sum(const LocalStage& stage, std::span<const double> q, std::span<double> g) const override;

  /// This rank's part of S at a displacement [m^3].
  double swept(std::span<const double> q) const;
  /// Gauge pressure at the sum of S over all ranks [Pa].
  double pressure(double S, const LoadState& at) const;

 private:
  WettedSurface walls_;
  CavityContent content_;
};

}  // namespace pliant
