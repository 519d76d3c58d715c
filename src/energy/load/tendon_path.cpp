#include "energy/load/tendon_path.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace pliant {
namespace {

/// A node of a point of a tendon, as it goes to all ranks.
struct NodeOfPoint {
  PetscInt point = 0, global_node = 0;
  double weight = 0.0;
};

/// The local number of a node; -1: this rank does not have it.
PetscInt local_node(const NodeLayout& layout, PetscInt global) {
  const PetscInt owned = global - layout.first_global_node;
  if (owned >= 0 && owned < layout.num_owned_nodes) return owned;
  const auto& ghosts = layout.ghost_global_nodes;
  const auto found = std::ranges::lower_bound(ghosts, global);
  if (found == ghosts.end() || *found != global) return -1;
  return layout.num_owned_nodes + static_cast<PetscInt>(found - ghosts.begin());
}

/// Points in space get the nodes of the nearest point in a body along the tendon, without weight: they are then known
/// wherever that one is.
void lend_nodes(std::vector<std::vector<PetscInt>>& nodes, std::vector<std::vector<double>>& weights) {
  const auto lend = [&](std::size_t from, std::size_t to) {
    if (nodes[from].empty() || !nodes[to].empty()) return;
    nodes[to] = nodes[from];
    weights[to].assign(weights[from].size(), 0.0);
  };
  for (std::size_t k = 1; k < nodes.size(); ++k) lend(k - 1, k);
  for (std::size_t k = nodes.size() - 1; k > 0; --k) lend(k, k - 1);
}

struct Segments final : PairFeatures {
  std::vector<TendonSegment> all;
};

}  // namespace

Vector3<double> TendonSegment::way(const NearPatches& near, std::span<const double> q) const {
  Vector3<double> d = rest;
  for (std::size_t a = 0; a < nodes.size(); ++a) d = d + weights[a] * near.position(nodes[a], q);
  return d;
}

Vector3<double> TendonSegment::moved(std::span<const double> q, std::span<const double> from) const {
  Vector3<double> change{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const auto n = 3 * static_cast<std::size_t>(nodes[a]);
    for (std::size_t i = 0; i < 3; ++i) change[i] += weights[a] * (q[n + i] - (from.empty() ? 0.0 : from[n + i]));
  }
  return change;
}

// |a| - |b| = (a - b) . (a + b) / (|a| + |b|)
double TendonSegment::lengthening(const NearPatches& near, std::span<const double> q,
                                  std::span<const double> from) const {
  const Vector3<double> now = way(near, q), change = moved(q, from), then = now - change;
  return dot(change, now + then) / (norm(now) + norm(then));
}

void TendonSegment::add_force(const NearPatches& near, const Vector3<double>& force, std::span<double> r) const {
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    if (!near.is_owned(nodes[a])) continue;
    for (std::size_t i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(nodes[a]) + i] += weights[a] * force[i];
  }
}

TendonPath::TendonPath(const NodeLayout& layout, const std::vector<AttachedPoint>& points, Couples couples)
    : couples_(couples), weights_(points.size()) {
  std::vector<NodeOfPoint> mine;
  for (std::size_t k = 0; k < points.size(); ++k) {
    rests_.push_back(points[k].fixed.value_or(Vector3<double>{}));
    const ProbeLocation& location = points[k].location;
    for (std::size_t a = 0; a < location.nodes.size(); ++a) {
      mine.push_back({static_cast<PetscInt>(k), layout.global_node(location.nodes[a]), location.weights[a]});
    }
  }
  std::vector<std::vector<PetscInt>> globals(points.size());
  for (const NodeOfPoint& node : gathered(layout.comm, mine)) {
    globals[static_cast<std::size_t>(node.point)].push_back(node.global_node);
    weights_[static_cast<std::size_t>(node.point)].push_back(node.weight);
  }
  lend_nodes(globals, weights_);
  // A point at a node has that alone: patches are of one size, so it is repeated without weight.
  std::size_t most = 1;
  for (const auto& nodes : globals) most = std::max(most, nodes.size());
  patches_.nodes_per_patch = static_cast<int>(most);
  for (std::size_t k = 0; k < globals.size(); ++k) {
    globals[k].resize(most, globals[k].front());
    weights_[k].resize(most, 0.0);
    std::vector<PetscInt> local;
    for (const PetscInt node : globals[k]) local.push_back(local_node(layout, node));
    const auto is_mine = [&](PetscInt node) { return node >= 0 && node < layout.num_owned_nodes; };
    if (std::ranges::none_of(local, is_mine)) continue;
    patches_.nodes.insert(patches_.nodes.end(), local.begin(), local.end());
    patches_.keys.push_back(static_cast<std::int64_t>(k));
    patches_.tags.push_back(0);
    patches_.is_owned.push_back(is_mine(local.front()) ? 1 : 0);
  }
}

std::shared_ptr<const PairFeatures> TendonPath::features_of(const NearPatches& near) const {
  auto features = std::make_shared<Segments>();
  std::map<std::int64_t, std::size_t> patch_of;
  for (std::size_t p = 0; p < near.patches.size(); ++p) patch_of.emplace(near.patches.keys[p], p);
  for (const auto& [key, patch] : patch_of) {
    const auto next = patch_of.find(key + 1);
    if (next == patch_of.end()) continue;
    const auto first = static_cast<std::size_t>(key);
    TendonSegment& segment = features->all.emplace_back();
    segment.number = first;
    segment.rest = rests_[first + 1] - rests_[first];
    segment.is_counted = near.patches.is_owned[patch] != 0;
    const std::array<std::size_t, 2> ends{patch, next->second};
    for (std::size_t end = 0; end < 2; ++end) {
      const auto nodes = near.patches.nodes_of(ends[end]);
      const auto& weights = weights_[first + end];
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        if (weights[a] == 0.0) continue;
        segment.nodes.push_back(nodes[a]);
        segment.weights.push_back(end == 0 ? -weights[a] : weights[a]);
      }
    }
  }
  return features;
}

const std::vector<TendonSegment>& TendonPath::segments(const NearPatches& near) {
  static const std::vector<TendonSegment> none;
  return near.features ? static_cast<const Segments&>(*near.features).all : none;
}

}  // namespace pliant
