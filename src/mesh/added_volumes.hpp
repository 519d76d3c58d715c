/// Bodies of files of their own as volumes of a serial mesh.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Appends `source.added_volumes`, each as a volume; of their groups and curved edges nothing is kept. Throws
/// InputError at the file's place, MeshDefect if the mesh has a volume of one of these names. Not collective.
void add_volumes(const MeshSource& source, SerialMesh& mesh);

/// Appends a volume, a group of cells. Throws MeshDefect if the mesh has a volume of this name.
void add_volume_group(const std::string& name, std::vector<PetscInt> cells, SerialMesh& mesh);

/// Extends the data of cells to all cells, without values.
void complete_cell_data(SerialMesh& mesh);

}  // namespace pliant
