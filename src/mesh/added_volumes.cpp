#include "mesh/added_volumes.hpp"

#include "mesh/added_nodes.hpp"
#include "mesh/gmsh_import.hpp"
#include "mesh/mesh_file.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace pliant {
namespace {

void append(const AddedVolume& volume, const SerialMesh& added, SerialMesh& mesh) {
  const bool has_middles = mesh.geometry_order() == 2;
  AddedNodes nodes(mesh);
  std::vector<PetscInt> numbers;
  for (std::size_t n = 0; n < added.num_nodes(); ++n) {
    const double* x = added.node(static_cast<PetscInt>(n));
    numbers.push_back(nodes.add({volume.scale * x[0], volume.scale * x[1], volume.scale * x[2]}));
  }
  std::vector<PetscInt> members;
  for (std::size_t c = 0; c < added.num_cells(); ++c) {
    CornerNodes corners{};
    for (std::size_t a = 0; a < 4; ++a) corners[a] = numbers[static_cast<std::size_t>(added.cells[4 * c + a])];
    members.push_back(nodes.add_cell(corners, has_middles));
  }
  add_volume_group(volume.name, std::move(members), mesh);
}

}  // namespace

void add_volume_group(const std::string& name, std::vector<PetscInt> cells, SerialMesh& mesh) {
  int tag = 0;
  for (const SerialGroup& group : mesh.groups) {
    if (group.group.dimension != 3) continue;
    tag = std::max(tag, group.group.tag);
    if (group.group.name != name) continue;
    throw MeshDefect("it has a volume '" + name +
                     "', which is also the name of a rigid body, a rod or a free shell: rename one");
  }
  mesh.groups.push_back({{3, tag + 1, name}, std::move(cells)});
}

void complete_cell_data(SerialMesh& mesh) {
  for (CellField& field : mesh.cell_data) {
    field.values.resize(static_cast<std::size_t>(field.components) * mesh.num_cells(),
                        std::numeric_limits<double>::quiet_NaN());
  }
}

void add_volumes(const MeshSource& source, SerialMesh& mesh) {
  for (const AddedVolume& volume : source.added_volumes) {
    MeshSource of_volume;
    of_volume.file = volume.file;
    of_volume.where = volume.where;
    of_volume.size = volume.size;
    of_volume.commands = source.commands;
    of_volume.time_limit = source.time_limit;
    telling_the_user(of_volume, [&] {
      if (is_mesh_file(of_volume.file)) {
        throw MeshDefect("the shape of a rigid body is a surface (.stl), geometry or a .msh, not Pliant's own format");
      }
      append(volume, import_mesh(of_volume), mesh);
    });
  }
  if (!source.added_volumes.empty()) complete_cell_data(mesh);
}

}  // namespace pliant
