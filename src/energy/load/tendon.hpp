/// Tendons: strings through points of the bodies that are pulled with a given force.
#pragma once

#include "base/expression.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"
#include "fem/probe.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace pliant {

/// A string without friction: straight between its points x_0 .. x_n, which are fixed in the bodies; its tension T is
/// the same everywhere and given. Its potential is T l, l = sum |x_{k+1} - x_k|: convex, with the Hessian
/// T (I - n n^T) / |x_{k+1} - x_k| of each segment, n its direction.
class Tendon final : public EnergyTerm, public PairCoupling {
 public:
  /// `points`: places in the mesh, in their order along the tendon (the same on every rank, at least two). `tension`: a
  /// formula of t [N]. Collective.
  Tendon(const NodeLayout& layout, const std::vector<ProbeLocation>& points, Expression tension);

  const Patches& patches() const override { return patches_; }
  /// Neighbours along the tendon are near each other wherever they are.
  double reach() const override { return 1e9; }
  bool may_couple(int /*tag*/, int /*other*/) const override { return true; }
  bool couples(std::int64_t key, std::int64_t other) const override { return key - other == 1 || other - key == 1; }

  std::string_view name() const override { return "tendon"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;

  double tension(double time, double factor) const { return factor * tension_(0.0, 0.0, 0.0, time); }

 private:
  /// A segment that this rank sees: the nodes of its ends and the weights of the second less those of the first, so
  /// that sum_a w_a x_a is the way from one end to the other.
  struct Segment {
    std::vector<PetscInt> nodes;
    std::vector<double> weights;
    bool is_counted = false;
  };
  std::vector<Segment> segments(const NearPatches& near) const;
  /// This rank's part of the length [m].
  double length(const NearPatches& near, std::span<const double> q) const;

  Patches patches_;
  std::vector<std::vector<double>> weights_;  // of the nodes of each point, by its key, on every rank
  Expression tension_;
};

}  // namespace pliant
