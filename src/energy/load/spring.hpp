/// Springs and dampers between two points of bodies, or one and the ground.
#pragma once

#include "energy/load/point_lines.hpp"
#include "energy/term.hpp"

#include <memory>
#include <string_view>
#include <vector>

namespace pliant {

/// Pulls its two points towards each other, along the line between them, with the force
///
///     f = k (l - l0) + c l',    l = |d|
struct LineSpring {
  double stiffness = 0.0;        ///< k [N/m]
  double rest = 0.0;             ///< l0 [m]
  double damping = 0.0;          ///< c [N s/m]
  bool is_tension_only = false;  ///< no force below l0

  /// k (l - l0) [N].
  double elastic_force(double length) const;
  /// f at the way d from one point to the other and its rate [N].
  double force(const Vector3<double>& d, const Vector3<double>& rate) const;
};

/// What springs and dampers between points have in common: their lines, wherever the points are.
class LineTerm : public EnergyTerm, public PairCoupling {
 public:
  /// `points`: two for each of the springs. Collective.
  LineTerm(const NodeLayout& layout, std::span<const AttachedPoint> points, std::vector<LineSpring> springs);

  const Patches& patches() const override { return pairs_.patches(); }
  double reach() const override { return 1.0; }
  bool may_couple(int /*tag*/, int /*other*/) const override { return true; }
  const FixedPairs* fixed_pairs() const override { return &pairs_.fixed_pairs(); }
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }

 protected:
  static const std::vector<PointLine>& lines(const NearPatches& near);
  const LineSpring& spring_of(const PointLine& line) const { return springs_[line.number]; }

 private:
  PointLines pairs_;
  std::vector<LineSpring> springs_;
};

/// The potential k/2 (l - l0)^2 of each spring. With n = d / l its gradient in d is k (l - l0) n, and its Hessian
/// k n n^T + k (l - l0)/l (I - n n^T). It depends on the configuration alone: every method keeps its order. Points that
/// coincide have no n, and no force unless l0 = 0, where the potential is k/2 |d|^2 and smooth.
class Springs final : public LineTerm {
 public:
  using LineTerm::LineTerm;

  std::string_view name() const override { return "springs"; }
  TermDeclaration declaration() const override;
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;
};

/// The force c l' n of each damper, with the rate l' = n . d' at the end of the stage, d' = (d - d0)/dt. The rate
/// (l - l0)/dt would have a potential, and the first order for every method (docs/theory.md, "Strain rates and their
/// orders"); this one keeps the order of every method. Its Hessian, for P = I - n n^T, is
/// c (n n^T / dt + n (P d')^T / l + l' P / l), unsymmetric.
class Dampers final : public LineTerm {
 public:
  using LineTerm::LineTerm;

  std::string_view name() const override { return "spring-dampers"; }
  TermDeclaration declaration() const override;
  double value(const LocalStage& /*stage*/, std::span<const double> /*q*/) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;
};

}  // namespace pliant
