#include "energy/load/tendon_path.hpp"

#include <map>

namespace pliant {
namespace {

/// Points in space get the nodes of the nearest point in a body along the tendon, without weight: they are then known
/// wherever that one is.
NodesOfPoints with_lent_nodes(NodesOfPoints points) {
  const auto lend = [&](std::size_t from, std::size_t to) {
    if (points.nodes[from].empty() || !points.nodes[to].empty()) return;
    points.nodes[to] = points.nodes[from];
    points.weights[to].assign(points.weights[from].size(), 0.0);
  };
  for (std::size_t k = 1; k < points.nodes.size(); ++k) lend(k - 1, k);
  for (std::size_t k = points.nodes.size() - 1; k > 0; --k) lend(k, k - 1);
  return points;
}

struct Segments final : PairFeatures {
  std::vector<PointLine> all;
};

}  // namespace

TendonPath::TendonPath(const NodeLayout& layout, const std::vector<AttachedPoint>& points, Couples couples)
    : couples_(couples),
      points_(with_lent_nodes(nodes_of_points(layout, points))),
      patches_(patches_of_points(layout, points_, [](std::size_t) { return 0; })) {
  for (const AttachedPoint& point : points) fixed_.push_back(point.fixed.value_or(Vector3<double>{}));
}

std::shared_ptr<const PairFeatures> TendonPath::features_of(const NearPatches& near) const {
  auto features = std::make_shared<Segments>();
  std::map<std::int64_t, std::size_t> patch_of;
  for (std::size_t p = 0; p < near.patches.size(); ++p) patch_of.emplace(near.patches.keys[p], p);
  for (const auto& [key, patch] : patch_of) {
    const auto next = patch_of.find(key + 1);
    if (next == patch_of.end()) continue;
    const auto first = static_cast<std::size_t>(key);
    LineMaker segment(near);
    for (const std::size_t end : {0, 1}) {
      const double sign = end == 0 ? -1.0 : 1.0;
      segment.add_fixed(sign, fixed_[first + end]);
      segment.add_end(sign, near.patches.nodes_of(end == 0 ? patch : next->second), points_.weights[first + end]);
    }
    features->all.push_back(std::move(segment).take(first, near.patches.is_owned[patch] != 0));
  }
  return features;
}

const std::vector<PointLine>& TendonPath::segments(const NearPatches& near) {
  static const std::vector<PointLine> none;
  return near.features ? static_cast<const Segments&>(*near.features).all : none;
}

}  // namespace pliant
