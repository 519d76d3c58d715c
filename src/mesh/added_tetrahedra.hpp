/// Bodies without a mesh as tetrahedra of a serial mesh.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <span>

namespace pliant {

/// Appends each tetrahedron as a volume of its own, cut into 8 as often as needed for `fewest_cells` in the whole mesh.
/// Throws MeshDefect if the mesh has a volume of one of these names. Not collective.
void add_tetrahedra(std::span<const AddedTetrahedron> added, std::size_t fewest_cells, SerialMesh& mesh);

}  // namespace pliant
