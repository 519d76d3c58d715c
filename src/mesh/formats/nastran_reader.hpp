/// Reads meshes of Nastran.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads the bulk data of a file (.bdf, .nas), in small, large or free fields: nodes (GRID), tetrahedra (CTETRA),
/// triangles (CTRIA3, CTRIA6) and lines (CBAR, CBEAM, CROD), all others are skipped. The number of an element's
/// property (PSOLID, PSHELL, ...) is that of its volume, surface or curve. Source: MSC Nastran Quick Reference Guide.
/// Throws MeshDefect with the line of the error; FileError if the file cannot be read. Not collective.
SerialMesh read_nastran(const std::string& file);

}  // namespace pliant
