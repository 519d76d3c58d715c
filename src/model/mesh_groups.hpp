/// The physical groups of the mesh, as results name them.
#pragma once

#include "fem/layout.hpp"

#include <string>
#include <vector>

namespace pliant {

/// A group of the mesh, and what this rank has of it: of a volume the owned cells, of a surface the nodes of the owned
/// facets (3 or 6 each), of a curve or points the owned nodes. Local numbers; there may be none.
struct MeshGroup {
  std::string name;   ///< or its number, where it has no name
  int dimension = 3;  ///< 0 points, 1 curve, 2 surface, 3 volume
  std::vector<PetscInt> entries;
};

/// All groups of the mesh, the same on every rank. Facets that bound no cell are left out. Not collective.
std::vector<MeshGroup> find_mesh_groups(const Mesh& mesh, const NodeLayout& layout);

}  // namespace pliant
