#include "mesh/added_tetrahedra.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace pliant {
namespace {

using CornerNodes = std::array<PetscInt, 4>;

/// NodesOfBody of a tetrahedron's cells, made as they are needed.
class NodesOfBody {
 public:
  explicit NodesOfBody(SerialMesh& mesh) : mesh_(mesh) {}

  PetscInt add(const std::array<double, 3>& x) {
    mesh_.coordinates.insert(mesh_.coordinates.end(), x.begin(), x.end());
    mesh_.node_tags.push_back(mesh_.num_nodes());
    return static_cast<PetscInt>(mesh_.num_nodes()) - 1;
  }
  PetscInt middle(PetscInt a, PetscInt b) {
    const auto [found, is_new] = middles_.try_emplace({std::min(a, b), std::max(a, b)}, 0);
    if (is_new) {
      std::array<double, 3> x{};
      for (std::size_t i = 0; i < 3; ++i) x[i] = 0.5 * (mesh_.node(a)[i] + mesh_.node(b)[i]);
      found->second = add(x);
    }
    return found->second;
  }

 private:
  SerialMesh& mesh_;
  std::map<std::pair<PetscInt, PetscInt>, PetscInt> middles_;
};

/// The eight tetrahedra between corners and middles of edges, oriented as the whole.
std::vector<CornerNodes> cut(const CornerNodes& c, NodesOfBody& nodes) {
  const PetscInt a = nodes.middle(c[0], c[1]), b = nodes.middle(c[0], c[2]), d = nodes.middle(c[0], c[3]),
                 e = nodes.middle(c[1], c[2]), f = nodes.middle(c[1], c[3]), g = nodes.middle(c[2], c[3]);
  return {{c[0], a, b, d}, {a, c[1], e, f}, {b, e, c[2], g}, {d, f, g, c[3]},
          {a, b, d, f},    {a, e, b, f},    {b, g, d, f},    {b, e, g, f}};
}

}  // namespace

void add_tetrahedra(std::span<const AddedTetrahedron> added, SerialMesh& mesh) {
  if (added.empty()) return;
  const bool has_middles = mesh.geometry_order() == 2;
  int tag = 0;
  for (const SerialGroup& group : mesh.groups) {
    if (group.group.dimension == 3) tag = std::max(tag, group.group.tag);
  }
  // The same for any number of ranks: runs are resumed on others.
  const std::size_t cells_of_each = mesh.num_cells() == 0 ? 8 : 1;
  for (const AddedTetrahedron& body : added) {
    for (const SerialGroup& group : mesh.groups) {
      if (group.group.dimension != 3 || group.group.name != body.name) continue;
      throw MeshDefect("it has a volume '" + body.name + "', which is also the name of a rigid body: rename one");
    }
    NodesOfBody nodes(mesh);
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
    SerialGroup group{{3, ++tag, body.name}, {}};
    for (const CornerNodes& cell : cells) {
      group.members.push_back(static_cast<PetscInt>(mesh.num_cells()));
      mesh.cells.insert(mesh.cells.end(), cell.begin(), cell.end());
      mesh.cell_tags.push_back(mesh.num_cells());
      if (!has_middles) continue;
      for (const auto& [i, j] : local_edges) {
        mesh.mid_nodes.push_back(nodes.middle(cell[static_cast<std::size_t>(i)], cell[static_cast<std::size_t>(j)]));
      }
    }
    mesh.groups.push_back(std::move(group));
  }
  for (CellField& field : mesh.cell_data) {
    field.values.resize(static_cast<std::size_t>(field.components) * mesh.num_cells(),
                        std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace pliant
