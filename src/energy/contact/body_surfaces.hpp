/// The surfaces of bodies that may touch one another, as one collision surface that all ranks know at rest.
#pragma once

#include "collision/surface.hpp"
#include "energy/coupling.hpp"
#include "fem/selection.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// What a facet belongs to: its body, which has its own contact law with every other body, and the set of facets in
/// which it takes part, which decides what it may touch.
struct FacetSide {
  std::int32_t body = 0;
  std::int32_t set = 0;
};

/// Triangles of the facets of all ranks, numbered alike on every rank: one per linear facet, the four between the six
/// nodes of a quadratic one. Memory: about 100 bytes per triangle of all bodies on each rank.
class BodySurfaces {
 public:
  /// `sides`: of each facet. Facets inside the mesh (FacetList::is_outer) are not allowed. The layout outlives the
  /// object. Collective.
  BodySurfaces(const NodeLayout& layout, const FacetList& facets, std::span<const FacetSide> sides);

  const CollisionSurface& surface() const { return surface_; }
  /// The triangles with a node of this rank: nodes in the order of their vertices, keys are their numbers, tags their
  /// sets. A triangle is owned by the rank of its first node.
  const Patches& patches() const { return patches_; }

  /// Whether the triangle stands for its k-th vertex or edge: it is the first of its set that has it. What is near one
  /// of a set's triangles is then asked of each vertex and edge once.
  bool stands_for_vertex(std::size_t triangle, int k) const { return (stands_for_[triangle] >> k & 1) != 0; }
  bool stands_for_edge(std::size_t triangle, int k) const { return (stands_for_[triangle] >> (3 + k) & 1) != 0; }

 private:
  CollisionSurface surface_;
  Patches patches_;
  std::vector<std::uint8_t> stands_for_;  // of each triangle, a bit for each of its vertices, then of its edges
};

}  // namespace pliant
