#include "energy/shell/bending_stencils.hpp"

#include "energy/shell/plate_patch.hpp"

#include <algorithm>
#include <map>

namespace pliant {
namespace {

/// Makes what a rank sees of the layer.
class StencilMaker {
 public:
  StencilMaker(const ShellTopology& topology, std::span<const BendingStiffness> stiffness, const NearPatches& near)
      : topology_(topology), stiffness_(stiffness), near_(near), seen_(std::make_shared<BendingStencils>()) {
    for (std::size_t p = 0; p < near.patches.size(); ++p) place_.emplace(near.patches.keys[p], p);
  }

  std::shared_ptr<const BendingStencils> make() {
    for (const auto& [key, p] : place_) {
      const auto triangle = static_cast<std::size_t>(key);
      const auto patch = topology_.patch(triangle);
      const auto is_known = [&](std::int64_t other) { return place_.contains(other); };
      const auto has_owned_node = [&](std::int64_t other) {
        const auto nodes = near_.patches.nodes_of(place_.at(other));
        return std::ranges::any_of(nodes, [&](PetscInt node) { return near_.is_owned(node); });
      };
      if (std::ranges::all_of(patch, is_known) && std::ranges::any_of(patch, has_owned_node)) {
        add_stencil(triangle, p);
      }
    }
    return seen_;
  }

 private:
  PetscInt node(std::size_t triangle, std::size_t corner) const {
    return near_.patches.nodes_of(place_.at(static_cast<std::int64_t>(triangle)))[corner % 3];
  }
  Vector3<double> position(PetscInt node) const {
    const auto i = 3 * static_cast<std::size_t>(node);
    return {near_.coordinates[i], near_.coordinates[i + 1], near_.coordinates[i + 2]};
  }
  /// The unit vector across the plane that a clamped side lies in.
  Vector3<double> mirror(std::size_t triangle, std::size_t k, const ClampedEdge& edge) const {
    if (edge.has_normal != 0) return unit(Vector3<double>(edge.normal));
    const Vector3<double> a = position(node(triangle, k)), e = position(node(triangle, k + 1)) - a,
                          u = position(node(triangle, k + 2)) - a;
    return unit(cross(e, cross(e, u)));
  }

  const PlateFit& fit(std::size_t triangle) {
    const auto [found, is_new] = fits_.try_emplace(triangle);
    if (!is_new) return found->second;
    PlateTriangle plate;
    for (std::size_t k = 0; k < 3; ++k) {
      plate.corners[k] = position(node(triangle, k));
      const std::int64_t edge = topology_.edge_at(triangle, k);
      if (edge < 0) continue;
      const ShellTopology::Side other = topology_.across(triangle, k);
      if (other.triangle >= 0) {
        plate.sides[k] = PlateSide::folded;
        plate.others[k] = position(node(static_cast<std::size_t>(other.triangle), other.k + 2));
      } else {
        plate.sides[k] = PlateSide::mirrored;
        const Vector3<double> a = position(node(triangle, k)), u = position(node(triangle, k + 2)) - a,
                              m = mirror(triangle, k, *topology_.edges()[static_cast<std::size_t>(edge)].clamped);
        plate.others[k] = a + (u - (2.0 * dot(u, m)) * m);
      }
    }
    return found->second = fit_plate(plate, stiffness_[triangle].poissons_ratio);
  }

  std::size_t hinge_at(std::size_t triangle, std::size_t k) {
    const auto number = static_cast<std::size_t>(topology_.edge_at(triangle, k));
    const auto [found, is_new] = hinges_.try_emplace(number, seen_->hinges.size());
    if (!is_new) return found->second;
    const ShellTopology::Edge& edge = topology_.edges()[number];
    const auto first = static_cast<std::size_t>(edge.sides[0].triangle);
    BendingHinge hinge;
    for (std::size_t c = 0; c < 3; ++c) hinge.nodes[c] = node(first, edge.sides[0].k + c);
    if (edge.clamped) {
      hinge.mirror = mirror(first, edge.sides[0].k, *edge.clamped);
    } else {
      hinge.nodes[3] = node(static_cast<std::size_t>(edge.sides[1].triangle), edge.sides[1].k + 2);
    }
    hinge.rest = hinge.vectors(near_.coordinates);
    seen_->hinges.push_back(hinge);
    return found->second;
  }
  /// 1, or -1 where the angle of the edge has the opposite sign for this triangle.
  double sign_at(std::size_t triangle, std::size_t k) const {
    const ShellTopology::Edge& edge = topology_.edges()[static_cast<std::size_t>(topology_.edge_at(triangle, k))];
    return edge.is_oriented || edge.sides[0].triangle == static_cast<std::int64_t>(triangle) ? 1.0 : -1.0;
  }

  void add_stencil(std::size_t triangle, std::size_t patch);
  void list_nodes(BendingStencil& stencil) const;

  const ShellTopology& topology_;
  std::span<const BendingStiffness> stiffness_;
  const NearPatches& near_;
  std::shared_ptr<BendingStencils> seen_;
  std::map<std::int64_t, std::size_t> place_;  // of patches by their keys
  std::map<std::size_t, PlateFit> fits_;       // by triangles
  std::map<std::size_t, std::size_t> hinges_;  // by edges
};

void StencilMaker::add_stencil(std::size_t triangle, std::size_t patch) {
  std::array<PlateNeighbour, 3> neighbours;
  std::array<std::size_t, 3> numbers{};
  for (std::size_t k = 0; k < 3; ++k) {
    const ShellTopology::Side other = topology_.across(triangle, k);
    if (other.triangle < 0) continue;
    if (!topology_.edges()[static_cast<std::size_t>(topology_.edge_at(triangle, k))].is_oriented) continue;
    numbers[k] = static_cast<std::size_t>(other.triangle);
    neighbours[k] = {&fit(numbers[k]), other.k};
  }
  const PlateFit& own = fit(triangle);
  const PlateCurvature columns = plate_curvature(own, neighbours);
  BendingStencil stencil;
  stencil.is_counted = near_.patches.is_owned[patch] != 0;
  stencil.patch = patch;
  std::array<std::array<double, 3>, BendingStencil::most_hinges> G{};
  const auto add = [&](std::size_t of, std::size_t k, const std::array<double, 3>& column) {
    if (topology_.edge_at(of, k) < 0) return;
    const std::size_t hinge = hinge_at(of, k);
    const auto end = stencil.hinges.begin() + static_cast<std::ptrdiff_t>(stencil.num_hinges);
    const auto place = static_cast<std::size_t>(std::find(stencil.hinges.begin(), end, hinge) - stencil.hinges.begin());
    if (place == stencil.num_hinges) stencil.hinges[stencil.num_hinges++] = hinge;
    for (std::size_t i = 0; i < 3; ++i) G[place][i] += sign_at(of, k) * column[i];
  };
  for (std::size_t k = 0; k < 3; ++k) add(triangle, k, columns[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t j = 0; neighbours[k].fit != nullptr && j < 3; ++j) add(numbers[k], j, columns[3 + 3 * k + j]);
  }
  if (stencil.num_hinges == 0) return;
  const BendingStiffness& stiffness = stiffness_[triangle];
  stencil.stiffness = stiffness;
  stencil.is_surrounded =
      std::ranges::all_of(own.sides, [](const PlateFit::Side& side) { return side.kind == PlateSide::folded; });
  stencil.area = own.area;
  const auto T = plate_extension(own, stiffness.poissons_ratio);
  for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
    for (std::size_t i = 0; i < 9; ++i) stencil.curvature[h][i / 3] += T[i] * G[h][i % 3];
  }
  const auto C = plate_stiffness(own, stiffness.rigidity, stiffness.poissons_ratio);
  for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
    for (std::size_t g = 0; g <= h; ++g) {
      double entry = 0.0;
      for (std::size_t i = 0; i < 9; ++i) entry += G[h][i / 3] * C[i] * G[g][i % 3];
      stencil.M[BendingStencil::most_hinges * h + g] = stencil.M[BendingStencil::most_hinges * g + h] =
          own.area * entry;
    }
  }
  list_nodes(stencil);
  seen_->stencils.push_back(stencil);
}

void StencilMaker::list_nodes(BendingStencil& stencil) const {
  for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
    for (std::size_t a = 0; a < 4; ++a) {
      const PetscInt node = seen_->hinges[stencil.hinges[h]].nodes[a];
      if (node < 0) {
        stencil.places[h][a] = -1;
        continue;
      }
      const auto end = stencil.nodes.begin() + static_cast<std::ptrdiff_t>(stencil.num_nodes);
      const auto place = std::find(stencil.nodes.begin(), end, node) - stencil.nodes.begin();
      if (static_cast<std::size_t>(place) == stencil.num_nodes) stencil.nodes[stencil.num_nodes++] = node;
      stencil.places[h][a] = static_cast<std::int8_t>(place);
    }
  }
}

}  // namespace

const BendingStencils& BendingStencils::seen(const NearPatches* near) {
  static const BendingStencils none;
  return near != nullptr && near->features ? static_cast<const BendingStencils&>(*near->features) : none;
}

HingeVectors BendingHinge::vectors(std::span<const double> x) const {
  HingeVectors result;
  const auto start = 3 * static_cast<std::size_t>(nodes[0]);
  for (std::size_t v = 0; v < 3; ++v) {
    if (nodes[v + 1] < 0) {
      result[2] = result[1] - (2.0 * dot(result[1], mirror)) * mirror;
      continue;
    }
    const auto end = 3 * static_cast<std::size_t>(nodes[v + 1]);
    for (std::size_t i = 0; i < 3; ++i) result[v][i] = x[end + i] - x[start + i];
  }
  return result;
}

HingeVectors BendingHinge::at(std::span<const double> q) const {
  HingeVectors result = vectors(q);
  for (std::size_t v = 0; v < 3; ++v) result[v] = rest[v] + result[v];
  return result;
}

std::shared_ptr<const BendingStencils> make_bending_stencils(const ShellTopology& topology,
                                                             std::span<const BendingStiffness> stiffness,
                                                             const NearPatches& near) {
  return StencilMaker(topology, stiffness, near).make();
}

}  // namespace pliant
