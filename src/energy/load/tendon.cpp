#include "energy/load/tendon.hpp"

#include "base/vector3.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>

namespace pliant {
namespace {

/// A node of a point of a tendon, as it goes to all ranks.
struct NodeOfPoint {
  PetscInt point = 0, place = 0, global_node = 0;
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

Vector3<double> way(const NearPatches& near, std::span<const PetscInt> nodes, std::span<const double> weights,
                    std::span<const double> q) {
  Vector3<double> result{};
  for (std::size_t a = 0; a < nodes.size(); ++a) result = result + weights[a] * near.position(nodes[a], q);
  return result;
}

}  // namespace

Tendon::Tendon(const NodeLayout& layout, const std::vector<ProbeLocation>& points, Expression tension)
    : weights_(points.size()), tension_(std::move(tension)) {
  std::vector<NodeOfPoint> mine;
  for (std::size_t k = 0; k < points.size(); ++k) {
    for (std::size_t a = 0; a < points[k].nodes.size(); ++a) {
      mine.push_back({static_cast<PetscInt>(k), static_cast<PetscInt>(a), layout.global_node(points[k].nodes[a]),
                      points[k].weights[a]});
    }
  }
  std::vector<std::vector<PetscInt>> globals(points.size());
  for (const NodeOfPoint& node : gathered(layout.comm, mine)) {
    globals[static_cast<std::size_t>(node.point)].push_back(node.global_node);
    weights_[static_cast<std::size_t>(node.point)].push_back(node.weight);
  }
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

TermDeclaration Tendon::declaration() const {
  TermDeclaration declaration;
  declaration.account = tension_.depends_on_time() ? Account::load : Account::load_potential;
  declaration.rotates_with_body = false;
  return declaration;
}

std::vector<Tendon::Segment> Tendon::segments(const NearPatches& near) const {
  std::vector<Segment> result;
  std::map<std::int64_t, std::size_t> patch_of;
  for (std::size_t p = 0; p < near.patches.size(); ++p) patch_of.emplace(near.patches.keys[p], p);
  for (const auto& [key, patch] : patch_of) {
    const auto next = patch_of.find(key + 1);
    if (next == patch_of.end()) continue;
    Segment segment;
    const std::array<std::size_t, 2> ends{patch, next->second};
    for (std::size_t end = 0; end < 2; ++end) {
      const auto nodes = near.patches.nodes_of(ends[end]);
      const auto& weights = weights_[static_cast<std::size_t>(key) + end];
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        if (weights[a] == 0.0) continue;
        segment.nodes.push_back(nodes[a]);
        segment.weights.push_back(end == 0 ? -weights[a] : weights[a]);
      }
    }
    segment.is_counted = near.patches.is_owned[patch] != 0;
    result.push_back(std::move(segment));
  }
  return result;
}

double Tendon::length(const NearPatches& near, std::span<const double> q) const {
  double sum = 0.0;
  for (const Segment& segment : segments(near)) {
    if (segment.is_counted) sum += norm(way(near, segment.nodes, segment.weights, q));
  }
  return sum;
}

double Tendon::value(const LocalStage& stage, std::span<const double> q) const {
  const double T = tension(stage.time, stage.load_factor);
  double sum = 0.0;
  for (const Segment& segment : segments(*stage.near)) {
    if (!segment.is_counted) continue;
    // |a| - |b| = (a - b) . (a + b) / (|a| + |b|): small changes keep their digits.
    const Vector3<double> now = way(*stage.near, segment.nodes, segment.weights, q);
    const Vector3<double> then = way(*stage.near, segment.nodes, segment.weights, stage.reference());
    sum += T * dot(now - then, now + then) / (norm(now) + norm(then));
  }
  return sum;
}

void Tendon::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const double T = tension(stage.time, stage.load_factor);
  for (const Segment& segment : segments(*stage.near)) {
    const Vector3<double> n = unit(way(*stage.near, segment.nodes, segment.weights, q));
    for (std::size_t a = 0; a < segment.nodes.size(); ++a) {
      if (!stage.near->is_owned(segment.nodes[a])) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        r[3 * static_cast<std::size_t>(segment.nodes[a]) + i] += T * segment.weights[a] * n[i];
      }
    }
  }
}

void Tendon::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                         Projection projection) const {
  const double T = tension(stage.time, stage.load_factor);
  if (projection != Projection::none && T < 0.0) return;
  for (const Segment& segment : segments(*stage.near)) {
    const Vector3<double> d = way(*stage.near, segment.nodes, segment.weights, q);
    const Vector3<double> n = unit(d);
    for (std::size_t a = 0; a < segment.nodes.size(); ++a) {
      if (!stage.near->is_owned(segment.nodes[a])) continue;
      for (std::size_t b = 0; b < segment.nodes.size(); ++b) {
        std::array<double, 9> block{};
        const double factor = T * segment.weights[a] * segment.weights[b] / norm(d);
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = factor * ((i == j ? 1.0 : 0.0) - n[i] * n[j]);
        }
        K.add(segment.nodes[a], segment.nodes[b], block);
      }
    }
  }
}

double Tendon::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  if (tension_.depends_on_time()) return 0.0;
  return tension(at.time, at.load_factor) * length(*at.near, q);
}

}  // namespace pliant
