#include "mesh/added_tetrahedra.hpp"

#include "mesh/added_nodes.hpp"
#include "mesh/added_volumes.hpp"

namespace pliant {
namespace {

/// The eight tetrahedra between corners and middles of edges, oriented as the whole.
std::vector<CornerNodes> cut(const CornerNodes& c, AddedNodes& nodes) {
  const PetscInt a = nodes.middle(c[0], c[1]), b = nodes.middle(c[0], c[2]), d = nodes.middle(c[0], c[3]),
                 e = nodes.middle(c[1], c[2]), f = nodes.middle(c[1], c[3]), g = nodes.middle(c[2], c[3]);
  return {{c[0], a, b, d}, {a, c[1], e, f}, {b, e, c[2], g}, {d, f, g, c[3]},
          {a, b, d, f},    {a, e, b, f},    {b, g, d, f},    {b, e, g, f}};
}

}  // namespace

void add_tetrahedra(std::span<const AddedTetrahedron> added, SerialMesh& mesh) {
  if (added.empty()) return;
  const bool has_middles = mesh.geometry_order() == 2;
  // The same for any number of ranks: runs are resumed on others.
  const std::size_t cells_of_each = mesh.num_cells() == 0 ? 8 : 1;
  for (const AddedTetrahedron& body : added) {
    AddedNodes nodes(mesh);
    CornerNodes corners{};
    for (std::size_t k = 0; k < 4; ++k) corners[k] = nodes.add(body.corners[k]);
    std::vector<CornerNodes> cells{corners};
    while (cells.size() < cells_of_each) {
      std::vector<CornerNodes> finer;
      for (const CornerNodes& cell : cells) {
        for (const CornerNodes& part : cut(cell, nodes)) finer.push_back(part);
      }
      cells = std::move(finer);
    }
    std::vector<PetscInt> members;
    for (const CornerNodes& cell : cells) members.push_back(nodes.add_cell(cell, has_middles));
    add_volume_group(body.name, std::move(members), mesh);
  }
  complete_cell_data(mesh);
}

}  // namespace pliant
