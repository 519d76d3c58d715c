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
  double thickness = 0.0;       ///< of a free shell or a rod [m]; 0: it is a side of a solid
  std::int32_t rigid_part = 0;  ///< with which it moves as a rigid body, from 1; 0: it deforms
};

/// The nodes of a segment of a rod from a to b as those of a facet: its last two corners are one (collision/surface).
std::vector<PetscInt> segment_as_facet(PetscInt a, PetscInt b, int nodes_per_facet);
/// Whether the nodes are those of a segment.
inline bool is_segment(std::span<const PetscInt> nodes) {
  return nodes[1] == nodes[2];
}

/// Where the vertices of the nodes between the corners of quadratic facets are.
enum class FacetVertices {
  mean,  ///< such that the triangles have the mean of their facet
  nodes  ///< at the nodes
};

/// Triangles of the facets of all ranks, numbered alike on every rank: one per linear facet and per segment of a rod,
/// four per quadratic facet.
/// Memory: about 100 bytes per triangle of all bodies on each rank.
///
/// Each node has a vertex. Those of the corners of facets are the nodes themselves. With FacetVertices::mean, in a
/// quadratic facet with the nodes a, b and m between them, the vertex of m is
///
///     x = (a + b)/2 + 4/3 (m - (a + b)/2)
///
/// so that over each facet the triangles and the quadratic surface have the same mean, whatever the displacements: a
/// uniform pressure on the triangles exerts the consistent forces of the facet's shape functions, 0 at its corners and
/// a third at each of its other nodes. (With vertices at the nodes, corners would have a twelfth each.) On plane facets
/// with m in the middle, the vertex is m.
class BodySurfaces {
 public:
  /// `sides`: of each facet. Facets inside the mesh (FacetList::is_outer) are not allowed. The layout outlives the
  /// object. Collective.
  BodySurfaces(const NodeLayout& layout, const FacetList& facets, std::span<const FacetSide> sides,
               FacetVertices vertices = FacetVertices::mean);

  const CollisionSurface& surface() const { return surface_; }
  /// The triangles that move with a node of this rank: keys are their numbers, tags their sets, nodes those of
  /// `nodes_of`. A triangle is owned by the rank of its first node.
  const Patches& patches() const { return patches_; }

  /// The nodes with which a triangle moves, by the numbers of their vertices: those of its own vertices, in their
  /// order; of quadratic facets three more, where the last ones may be repeated.
  std::span<const std::int32_t> nodes_of(std::size_t triangle) const {
    const auto n = static_cast<std::size_t>(patches_.nodes_per_patch);
    return std::span(nodes_of_triangles_).subspan(triangle * n, n);
  }

  /// The nodes with which a vertex moves, by the numbers of their vertices, and their weights.
  struct Support {
    std::array<std::int32_t, 3> nodes{};
    std::array<double, 3> weights{};
    int size = 0;
  };
  Support support(std::int32_t vertex) const;
  /// Turns positions, or displacements, of nodes into those of their vertices: those of `vertices`, or all.
  void place(std::span<const std::int32_t> vertices, std::span<Vector3<double>> x) const;
  void place(std::span<Vector3<double>> x) const;

  /// Whether the triangle stands for its k-th vertex or edge: it is the first of its set that has it. What is near one
  /// of a set's triangles is then asked of each vertex and edge once.
  bool stands_for_vertex(std::size_t triangle, int k) const { return (stands_for_[triangle] >> k & 1) != 0; }
  bool stands_for_edge(std::size_t triangle, int k) const { return (stands_for_[triangle] >> (3 + k) & 1) != 0; }

 private:
  /// The corners between which the node of a vertex is; none of those of corners, [0] = -1.
  using Ends = std::array<std::int32_t, 2>;

  void list_nodes();
  void list_patches(const NodeLayout& layout, const FacetList& facets);
  void place(std::int32_t vertex, std::span<Vector3<double>> x) const;

  CollisionSurface surface_;
  Patches patches_;
  std::vector<Ends> ends_;                        // of each vertex; empty where all vertices are nodes
  std::vector<std::int32_t> nodes_of_triangles_;  // nodes_per_patch of each
  std::vector<std::uint8_t> stands_for_;          // of each triangle, a bit for each of its vertices, then of its edges
};

/// The current positions of all nodes of the surfaces, as of their vertices, on every rank [m]; `q`: displacements of
/// local nodes. Collective.
std::vector<Vector3<double>> gathered_nodes(const NodeLayout& layout, const BodySurfaces& surfaces,
                                            std::span<const double> q);

/// The current positions of the vertices, on every rank [m]. Collective.
std::vector<Vector3<double>> gathered_positions(const NodeLayout& layout, const BodySurfaces& surfaces,
                                                std::span<const double> q);

}  // namespace pliant
