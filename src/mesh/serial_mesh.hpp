/// The whole mesh on one rank, between the reader and the distribution.
#pragma once

#include "mesh/mesh.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pliant {

/// A physical group with its members. Volumes list cells; lower dimensions list the corner nodes of their facets,
/// dimension + 1 numbers each.
struct SerialGroup {
  PhysicalGroup group;
  std::vector<PetscInt> members;
};

/// Nodes, tetrahedra and groups as the file has them, numbered from 0. Lengths are the file's, times MeshSource::scale.
struct SerialMesh {
  std::vector<double> coordinates;     ///< xyz per node [m]
  std::vector<std::size_t> node_tags;  ///< the file's number of each node, for messages
  std::vector<PetscInt> cells;         ///< 4 corner nodes per cell
  std::vector<PetscInt> mid_nodes;  ///< geometry_order 2: 6 nodes per cell, on the edges of `local_edges`; else empty
  std::vector<std::size_t> cell_tags;  ///< the file's number of each element, for messages
  std::vector<SerialGroup> groups;
  std::vector<CellField> cell_data;
  std::vector<std::string> notices;  ///< what the reader has to tell the user

  std::size_t num_nodes() const { return coordinates.size() / 3; }
  std::size_t num_cells() const { return cells.size() / 4; }
  int geometry_order() const { return mid_nodes.empty() ? 1 : 2; }
  const double* node(PetscInt i) const { return &coordinates[3 * static_cast<std::size_t>(i)]; }
};

/// Corners of the six edges of a tetrahedron, in the order of gmsh's second-order nodes 4..9 (the last two are swapped
/// against VTK).
inline constexpr std::array<std::array<int, 2>, 6> local_edges{{{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}}};

/// A mesh that cannot be used: every reason found, told by read_mesh as the user's mistake at the place that names the
/// file.
class MeshDefect : public std::runtime_error {
 public:
  explicit MeshDefect(std::vector<std::string> reasons);
  explicit MeshDefect(std::string reason) : MeshDefect(std::vector<std::string>{std::move(reason)}) {}
  const std::vector<std::string>& reasons() const { return reasons_; }

 private:
  std::vector<std::string> reasons_;
};

/// "physical surface 'clamp'", or with the tag if it has no name.
std::string describe(const PhysicalGroup& group);

/// Adds "physical surface 'clamp': 2 of its 8 elements are not part of a tetrahedron and were left out" if not all of
/// them were found. For groups of points, curves and surfaces.
void notice_left_out(const SerialGroup& group, std::size_t num_found, std::vector<std::string>& notices);

/// "3, 17, 20, ... (1204 in all)": the first few of many numbers, in the order given.
std::string first_few(const std::vector<std::size_t>& numbers);

}  // namespace pliant
