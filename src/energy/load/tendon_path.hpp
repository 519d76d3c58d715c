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

  /// All segments, lines from a point to the next one, in their order; none on a rank without a node of the tendon.
  static const std::vector<PointLine>& segments(const NearPatches& near);

 private:
  Couples couples_;
  NodesOfPoints points_;
  Patches patches_;
  std::vector<Vector3<double>> fixed_;  // of each point in space [m]
};

}  // namespace pliant
