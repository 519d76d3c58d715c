/// Reads VTK's legacy format.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads an unstructured grid (.vtk, versions 1 to 5.1, text or binary) as mesh_of_grid (vtk_grid.hpp) understands it.
/// Source: VTK File Formats, "Simple Legacy Formats". Throws MeshDefect with the line or byte of the error; FileError
/// if the file cannot be read. Not collective.
SerialMesh read_vtk(const std::string& file);

}  // namespace pliant
