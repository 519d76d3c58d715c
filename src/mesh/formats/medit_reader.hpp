/// Reads the text format of Medit.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads a mesh of three dimensions (.mesh): the reference of a tetrahedron is the number of its volume, that of a
/// triangle of its surface, that of an edge of its curve; 0 is none. References of vertices are ignored. Second-order
/// elements are in sections of their own (TetrahedraP2), or, as gmsh writes them, in those of the first order with more
/// nodes a line. Source: Frey, "Medit: an interactive mesh visualization software", INRIA RT-0253 (2001). Throws
/// MeshDefect with the line of the error; FileError if the file cannot be read. Not collective.
SerialMesh read_medit(const std::string& file);

}  // namespace pliant
