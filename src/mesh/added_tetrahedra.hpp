/// Bodies without a mesh as tetrahedra of a serial mesh.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <span>

namespace pliant {

/// Appends each tetrahedron as a volume of its own; cut into 8 where the mesh has no other cell, so that several ranks
/// have some.
/// Throws MeshDefect if the mesh has a volume of one of these names. Not collective.
void add_tetrahedra(std::span<const AddedTetrahedron> added, SerialMesh& mesh);

}  // namespace pliant
