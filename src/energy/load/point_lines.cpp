#include "energy/load/point_lines.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <map>

namespace pliant {
namespace {

/// Points coincide whose distance is a smaller part of their coordinates.
constexpr double rounding = 1e-14;

/// A node of a point, as it goes to all ranks.
struct NodeOfAttached {
  PetscInt point = 0, global_node = 0;
  double weight = 0.0;
};

/// The local number of a node; -1: this rank does not have it.
PetscInt local_node_of(const NodeLayout& layout, PetscInt global) {
  const PetscInt owned = global - layout.first_global_node;
  if (owned >= 0 && owned < layout.num_owned_nodes) return owned;
  const auto& ghosts = layout.ghost_global_nodes;
  const auto found = std::ranges::lower_bound(ghosts, global);
  if (found == ghosts.end() || *found != global) return -1;
  return layout.num_owned_nodes + static_cast<PetscInt>(found - ghosts.begin());
}

}  // namespace

Vector3<double> PointLine::change(std::span<const double> q, std::span<const double> from) const {
  Vector3<double> d{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const auto first = 3 * static_cast<std::size_t>(nodes[a]);
    for (std::size_t i = 0; i < 3; ++i) d[i] += weights[a] * (q[first + i] - (from.empty() ? 0.0 : from[first + i]));
  }
  return d;
}

// |a| - |b| = (a - b) . (a + b) / (|a| + |b|)
double PointLine::lengthening(std::span<const double> q, std::span<const double> from) const {
  const Vector3<double> now = way(q), moved = change(q, from), then = now - moved;
  const double sum = norm(now) + norm(then);
  return sum > 0.0 ? dot(moved, now + then) / sum : 0.0;
}

void PointLine::add_force(const NearPatches& near, const Vector3<double>& f, std::span<double> r) const {
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    if (!near.is_owned(nodes[a])) continue;
    for (std::size_t i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(nodes[a]) + i] += weights[a] * f[i];
  }
}

void PointLine::add_stiffness(const NearPatches& near, const std::array<double, 9>& block, const BlockWriter& K) const {
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    if (!near.is_owned(nodes[a])) continue;
    for (std::size_t b = 0; b < nodes.size(); ++b) {
      std::array<double, 9> part = block;
      for (double& entry : part) entry *= weights[a] * weights[b];
      K.add(nodes[a], nodes[b], part);
    }
  }
}

NodesOfPoints nodes_of_points(const NodeLayout& layout, std::span<const AttachedPoint> points) {
  std::vector<NodeOfAttached> mine;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const ProbeLocation& at = points[k].location;
    for (std::size_t a = 0; a < at.nodes.size(); ++a) {
      mine.push_back({static_cast<PetscInt>(k), layout.global_node(at.nodes[a]), at.weights[a]});
    }
  }
  NodesOfPoints result{std::vector<std::vector<PetscInt>>(points.size()),
                       std::vector<std::vector<double>>(points.size())};
  for (const NodeOfAttached& node : gathered(layout.comm, mine)) {
    result.nodes[static_cast<std::size_t>(node.point)].push_back(node.global_node);
    result.weights[static_cast<std::size_t>(node.point)].push_back(node.weight);
  }
  return result;
}

Patches patches_of_points(const NodeLayout& layout, NodesOfPoints& points,
                          const std::function<int(std::size_t)>& tag_of) {
  std::size_t most = 1;
  for (const auto& nodes : points.nodes) most = std::max(most, nodes.size());
  Patches patches;
  patches.nodes_per_patch = static_cast<int>(most);
  for (std::size_t k = 0; k < points.nodes.size(); ++k) {
    if (points.nodes[k].empty()) continue;
    // A point at a node has that alone: patches are of one size, so it is repeated without weight.
    points.nodes[k].resize(most, points.nodes[k].front());
    points.weights[k].resize(most, 0.0);
    std::vector<PetscInt> local;
    for (const PetscInt node : points.nodes[k]) local.push_back(local_node_of(layout, node));
    const auto is_mine = [&](PetscInt node) { return node >= 0 && node < layout.num_owned_nodes; };
    if (std::ranges::none_of(local, is_mine)) continue;
    patches.nodes.insert(patches.nodes.end(), local.begin(), local.end());
    patches.keys.push_back(static_cast<std::int64_t>(k));
    patches.tags.push_back(tag_of(k));
    patches.is_owned.push_back(is_mine(local.front()) ? 1 : 0);
  }
  return patches;
}

void LineMaker::add_end(double sign, std::span<const PetscInt> nodes, std::span<const double> weights) {
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    if (weights[a] == 0.0) continue;
    line_.nodes.push_back(nodes[a]);
    line_.weights.push_back(sign * weights[a]);
    const auto i = 3 * static_cast<std::size_t>(nodes[a]);
    add_place(sign * weights[a], {near_.coordinates[i], near_.coordinates[i + 1], near_.coordinates[i + 2]});
  }
}

void LineMaker::add_place(double weight, const Vector3<double>& place) {
  line_.at_rest = line_.at_rest + weight * place;
  size_ += std::abs(weight) * norm(place);
}

PointLine LineMaker::take(std::size_t number, bool is_counted) && {
  line_.number = number;
  line_.is_counted = is_counted;
  if (norm(line_.at_rest) <= rounding * size_) line_.at_rest = {};
  return std::move(line_);
}

PointLines::PointLines(const NodeLayout& layout, std::span<const AttachedPoint> points)
    : points_(nodes_of_points(layout, points)),
      patches_(patches_of_points(layout, points_, [](std::size_t /*k*/) { return 0; })) {
  for (const AttachedPoint& point : points) fixed_.push_back(point.fixed.value_or(Vector3<double>{}));
  std::map<std::size_t, std::size_t> place;
  for (std::size_t p = 0; p < patches_.size(); ++p) place.emplace(static_cast<std::size_t>(patches_.keys[p]), p);
  for (std::size_t k = 0; k < points.size(); k += 2) {
    const bool is_here = place.contains(k) || place.contains(k + 1);
    if (!is_here || points_.nodes[k].empty() || points_.nodes[k + 1].empty()) continue;
    for (const std::size_t point : {k, k + 1}) {
      if (!place.emplace(point, patches_.size() + fixed_pairs_.keys.size()).second) continue;
      fixed_pairs_.keys.push_back(static_cast<std::int64_t>(point));
      fixed_pairs_.tags.push_back(0);
      const auto& nodes = points_.nodes[point];
      fixed_pairs_.global_nodes.insert(fixed_pairs_.global_nodes.end(), nodes.begin(), nodes.end());
    }
    fixed_pairs_.pairs.push_back({place.at(k), place.at(k + 1)});
  }
}

std::vector<PointLine> PointLines::seen(const NearPatches& near) const {
  std::map<std::int64_t, std::size_t> patch_of;
  for (std::size_t p = 0; p < near.patches.size(); ++p) patch_of.emplace(near.patches.keys[p], p);
  std::vector<PointLine> result;
  for (std::size_t n = 0; 2 * n < fixed_.size(); ++n) {
    LineMaker line(near);
    bool is_seen = true, has_first = false, is_counted = false;
    for (std::size_t end = 0; end < 2 && is_seen; ++end) {
      const std::size_t point = 2 * n + end;
      const double sign = end == 0 ? -1.0 : 1.0;
      if (points_.nodes[point].empty()) {
        line.add_fixed(sign, fixed_[point]);
        continue;
      }
      const auto found = patch_of.find(static_cast<std::int64_t>(point));
      is_seen = found != patch_of.end();
      if (!is_seen) continue;
      line.add_end(sign, near.patches.nodes_of(found->second), points_.weights[point]);
      if (!has_first) is_counted = near.patches.is_owned[found->second] != 0;
      has_first = true;
    }
    if (is_seen && has_first) result.push_back(std::move(line).take(n, is_counted));
  }
  return result;
}

}  // namespace pliant
