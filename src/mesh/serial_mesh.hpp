/// The whole mesh on one rank, between reading and distribution.
#pragma once

#include "base/vector3.hpp"
#include "mesh/mesh.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A physical group with its members. Volumes list cells; groups of lower dimension list the corner nodes of their
/// members, dimension + 1 numbers each.
struct SerialGroup {
  PhysicalGroup group;
  std::vector<PetscInt> members;
};

/// Nodes, tetrahedra and groups as in the file, numbered from 0. Lengths are the file's, times MeshSource::scale.
struct SerialMesh {
  std::vector<double> coordinates;     ///< xyz per node [m]
  std::vector<std::size_t> node_tags;  ///< the file's number of each node, for messages
  std::vector<PetscInt> cells;         ///< 4 corner nodes per cell
  std::vector<PetscInt> mid_nodes;  ///< geometry_order 2: 6 nodes per cell, on the edges of `local_edges`; else empty
  std::vector<std::size_t> cell_tags;  ///< the file's number of each element, for messages
  std::vector<SerialGroup> groups;
  std::vector<CellField> cell_data;
  std::vector<std::string> notices;  ///< the reader's notes to the user
  bool is_straightened = false;      ///< gmsh meshed curved faces of a geometry, and left the edges straight
  std::string only;                  ///< without tetrahedra: what there is instead, "3 of type 3-node triangle"

  std::size_t num_nodes() const { return coordinates.size() / 3; }
  std::size_t num_cells() const { return cells.size() / 4; }
  int geometry_order() const { return mid_nodes.empty() ? 1 : 2; }
  const double* node(PetscInt i) const { return &coordinates[3 * static_cast<std::size_t>(i)]; }
  Vector3<double> place(PetscInt i) const { return {node(i)[0], node(i)[1], node(i)[2]}; }  ///< of a node [m]
};

/// Corners of the six edges of a tetrahedron, in the order of gmsh's second-order nodes 4..9 (the last two are swapped
/// relative to VTK).
inline constexpr std::array<std::array<int, 2>, 6> local_edges{{{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}}};

/// Corners of the facets; facet i is opposite to corner i.
inline constexpr std::array<std::array<int, 3>, 4> local_facets{{{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};

/// Local corners of the corners, edges, facets and the whole of a tetrahedron, by dimension, in the order in which
/// members of groups are numbered.
std::span<const int> local_part(int dimension, std::size_t number);
std::size_t num_local_parts(int dimension);

/// A mesh that cannot be used. Holds every reason found; read_mesh reports them as errors of the input at the place
/// that names the file.
class MeshDefect : public std::runtime_error {
 public:
  explicit MeshDefect(std::vector<std::string> reasons);
  explicit MeshDefect(std::string reason) : MeshDefect(std::vector<std::string>{std::move(reason)}) {}
  const std::vector<std::string>& reasons() const { return reasons_; }

 private:
  std::vector<std::string> reasons_;
};

/// That a mesh has no tetrahedra, only `what`.
MeshDefect no_tetrahedra(const std::string& what);

/// "physical surface 'clamp'", or the tag if it has no name.
std::string describe(const PhysicalGroup& group);

/// For groups of points, curves and surfaces: adds "physical surface 'clamp': 2 of its 8 elements are not part of a
/// tetrahedron and were left out" unless all members were found.
void notice_left_out(const SerialGroup& group, std::size_t num_found, std::vector<std::string>& notices);

/// "3, 17, 20, ... (1204 in all)": the first of many numbers, in the given order.
std::string first_few(const std::vector<std::size_t>& numbers);

}  // namespace pliant
