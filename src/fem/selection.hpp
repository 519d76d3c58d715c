/// Parts of a mesh: nodes and facets (boundary faces) selected by a physical group or a condition on the position.
#pragma once

#include "fem/layout.hpp"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace pliant {

/// Whether a reference position belongs to the selection.
using Region = std::function<bool(const std::array<double, 3>&)>;

/// Facets as local nodes: 3 or 6 per facet (corners, mid-edge nodes 01 12 02). Every facet with an owned node is in the
/// list of the node's owner, so sums into owned nodes are complete without communication; every facet is also in the
/// list of its own owner, whoever owns its nodes, so sums over owned facets are complete too. On the surface of the
/// mesh the corners are anticlockwise seen from outside: x_xi cross x_eta points outward.
struct FacetList {
  int nodes_per_facet = 3;
  std::vector<PetscInt> nodes;
  std::vector<char> is_owned;  ///< exactly one rank owns a facet
  std::vector<char>
      is_outer;  ///< on the surface of the mesh; otherwise cells lie on both sides, and neither side is outside
  PetscInt size() const { return static_cast<PetscInt>(nodes.size()) / nodes_per_facet; }
  std::span<const PetscInt> nodes_of(PetscInt facet) const {
    return std::span(nodes).subspan(facet * nodes_per_facet, nodes_per_facet);
  }
};

/// Edges as local nodes: 2 or 3 per edge (ends, mid-edge node), in the lists of the same ranks as a FacetList's facets.
struct EdgeList {
  int nodes_per_edge = 2;
  std::vector<PetscInt> nodes;
  std::vector<char> is_owned;  ///< exactly one rank owns an edge
  PetscInt size() const { return static_cast<PetscInt>(nodes.size()) / nodes_per_edge; }
};

/// Owned nodes on the group's points (for a volume: all nodes of its cells), ascending. Not collective.
std::vector<PetscInt> nodes_of_group(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group);

/// Owned nodes inside the region, ascending. Not collective.
std::vector<PetscInt> nodes_in_region(const NodeLayout& layout, const Region& inside);

/// Edges of a curve group. Not collective.
EdgeList edges_of_group(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group);

/// Facets of a surface group. Not collective.
FacetList facets_of_group(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group);

/// Facets of the body's surface with all nodes inside the region. Not collective.
FacetList surface_facets(const Mesh& mesh, const NodeLayout& layout, const Region& inside);

/// For each local cell the index into `volumes` of its group, -1 if none, -2 if several. Not collective.
std::vector<int> volume_of_cells(const Mesh& mesh, const NodeLayout& layout, const std::vector<PhysicalGroup>& volumes);

}  // namespace pliant
