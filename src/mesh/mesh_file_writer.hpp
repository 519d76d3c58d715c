/// Writes files of Pliant's own mesh format (mesh_file.hpp).
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Writes a mesh that was repaired and checked. Members of groups that no tetrahedron has are left out with a notice.
/// Throws MeshDefect for second-order geometry, FileError. Not collective.
void write_mesh_file(const std::string& file, SerialMesh& mesh);

}  // namespace pliant
