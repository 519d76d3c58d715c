/// Reads I-DEAS universal files.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads a universal file (.unv): nodes (datasets 15, 781, 2411), elements (2412) and groups (2429 to 2477) by name:
/// volumes of their tetrahedra, surfaces of their triangles, curves of their lines, and points of their nodes. Without
/// groups, the number of an element's physical property is that of its volume, surface or curve. Source: SDRC I-DEAS
/// universal dataset descriptions. Throws MeshDefect with the line of the error; FileError if the file cannot be read.
/// Not collective.
SerialMesh read_unv(const std::string& file);

}  // namespace pliant
