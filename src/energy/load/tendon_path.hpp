/// The path of a tendon: straight between points that are fixed in the bodies or in space.
#pragma once

#include "base/vector3.hpp"
#include "energy/coupling.hpp"
#include "energy/load/point_lines.hpp"
#include "fem/layout.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// The way from a point to the next one: d = rest + sum_a weights_a x_a.
struct TendonSegment {
  std::size_t number = 0;  ///< of its first point
  std::vector<PetscInt> nodes;
  std::vector<double> weights;  ///< those of its second point, less those of its first
  Vector3<double> rest{};
  bool is_counted = false;  ///< exactly one rank counts it

  /// d at displacements q.
  Vector3<double> way(const NearPatches& near, std::span<const double> q) const;
  /// d(q) - d(from), accurate relative to the change; an empty `from`: the reference configuration.
  Vector3<double> moved(std::span<const double> q, std::span<const double> from) const;
  /// |d(q)| - |d(from)|, likewise.
  double lengthening(const NearPatches& near, std::span<const double> q, std::span<const double> from) const;
  /// r += weights_a force on the owned nodes.
  void add_force(const NearPatches& near, const Vector3<double>& force, std::span<double> r) const;
};

/// Points of a tendon as patches of their nodes, which may be on different ranks.
class TendonPath final : public PairCoupling {
 public:
  /// Which points a Hessian couples: friction at a point depends on the whole path beyond it.
  enum class Couples { neighbours, all };

  /// `points`: in their order along the tendon, the same on every rank, at least two, one of them in a body.
  /// Collective.
  TendonPath(const NodeLayout& layout, const std::vector<AttachedPoint>& points, Couples couples);

  const Patches& patches() const override { return patches_; }
  /// Points of a tendon are near each other wherever they are.
  double reach() const override { return 1e9; }
  bool may_couple(int /*tag*/, int /*other*/) const override { return true; }
  bool couples(std::int64_t key, std::int64_t other) const override {
    return couples_ == Couples::all || key - other == 1 || other - key == 1;
  }
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override;

  /// All segments, in their order; none on a rank without a node of the tendon.
  static const std::vector<TendonSegment>& segments(const NearPatches& near);

 private:
  Couples couples_;
  Patches patches_;
  std::vector<std::vector<double>> weights_;  // of the nodes of each point, on every rank
  std::vector<Vector3<double>> rests_;        // of each point
};

}  // namespace pliant
