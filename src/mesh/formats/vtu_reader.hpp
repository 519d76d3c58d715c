/// Reads VTK's XML format.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads an unstructured grid (.vtu) of one piece as mesh_of_grid (vtk_grid.hpp) understands it: arrays as text, as
/// base64, or appended, raw or compressed by zlib, of either byte order. Source: VTK File Formats, "XML File Formats".
/// Throws MeshDefect that names the element of XML or the array; FileError if the file cannot be read. Not collective.
SerialMesh read_vtu(const std::string& file);

}  // namespace pliant
