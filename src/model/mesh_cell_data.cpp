#include "model/mesh_cell_data.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {

std::size_t MeshCellData::find(const std::string& name, int components, const Location& where) const {
  const auto found = std::ranges::find(mesh_.cell_data, name, &CellField::name);
  if (found == mesh_.cell_data.end()) {
    std::string names;
    for (const auto& data : mesh_.cell_data) names += (names.empty() ? "'" : ", '") + data.name + "'";
    throw InputError(where, names.empty()
                                ? fmt::format("the mesh has no cell data '{}', nor any other: cell data is the "
                                              "$ElementData of a .msh file (geometry that gmsh meshes has none)",
                                              name)
                                : fmt::format("the mesh has no cell data '{}'; it has {}", name, names));
  }
  if (found->components != components) {
    throw InputError(where, fmt::format("cell data '{}' of the mesh has {} components; {} {} needed", name,
                                        found->components, components, components == 1 ? "is" : "are"));
  }
  return static_cast<std::size_t>(found - mesh_.cell_data.begin());
}

std::span<const double> MeshCellData::at(std::size_t data, PetscInt cell) const {
  const CellField& field = mesh_.cell_data[data];
  const auto size = static_cast<std::size_t>(field.components);
  return {field.values.data() + size * static_cast<std::size_t>(layout_.cell_points[cell]), size};
}

}  // namespace pliant
