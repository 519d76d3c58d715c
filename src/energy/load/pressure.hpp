/// Follower pressure: acts along the current normal on the current area, so its forces rotate and grow with the body.
#pragma once

#include "base/expression.hpp"
#include "energy/load/wetted_surface.hpp"
#include "energy/term.hpp"
#include "fem/rim.hpp"

namespace pliant {

/// A pressure that is uniform on a surface without a free rim has the potential p S, where S is the volume that the
/// surface has swept (energy/load/wetted_surface.hpp). Otherwise the antisymmetric part of K, which belongs to the rim,
/// makes it circulatory: it has no potential.
class FollowerPressure final : public EnergyTerm {
 public:
  /// `pressure` [Pa], a function of X and t, presses inward where positive. The layout outlives the object.
  FollowerPressure(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets, Expression pressure,
                   Rim rim);

  std::string_view name() const override { return "pressure"; }
  TermDeclaration declaration() const override;
  bool has_adjoint() const override { return has_potential(); }
  /// Zero where there is no potential.
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  /// Adds nothing if K is to be projected: the projected Hessian then treats the load as constant.
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  /// p S of a pressure that has a potential and whose rim stays, relative to the reference configuration.
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;

 private:
  bool has_potential() const { return rim_ != Rim::free && !pressure_.depends_on_space(); }
  std::vector<double> pressures(const LocalStage& stage) const;

  WettedSurface surface_;
  Expression pressure_;
  Rim rim_;
};

}  // namespace pliant
