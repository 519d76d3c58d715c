#include "model/mesh_groups.hpp"

#include "fem/selection.hpp"

namespace pliant {
namespace {

std::vector<PetscInt> owned_cells(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group) {
  const std::vector<int> volume = volume_of_cells(mesh, layout, {group});
  std::vector<PetscInt> cells;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    if (volume[static_cast<std::size_t>(c)] == 0) cells.push_back(c);
  }
  return cells;
}

std::vector<PetscInt> nodes_of_owned_facets(const FacetList& facets) {
  std::vector<PetscInt> nodes;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    if (facets.is_owned[static_cast<std::size_t>(f)] == 0) continue;
    for (const PetscInt n : facets.nodes_of(f)) nodes.push_back(n);
  }
  return nodes;
}

}  // namespace

std::vector<MeshGroup> find_mesh_groups(const Mesh& mesh, const NodeLayout& layout) {
  std::vector<MeshGroup> groups;
  for (const PhysicalGroup& group : mesh.groups) {
    groups.push_back({group.name.empty() ? std::to_string(group.tag) : group.name, group.dimension, {}});
    groups.back().entries = group.dimension == 3   ? owned_cells(mesh, layout, group)
                            : group.dimension == 2 ? nodes_of_owned_facets(facets_of_group(mesh, layout, group))
                                                   : nodes_of_group(mesh, layout, group);
  }
  return groups;
}

}  // namespace pliant
