/// A strict reader of gmsh's mesh format: gmsh's own reader crashes on damaged files and cannot say where they are
/// damaged.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <string>

namespace pliant {

/// Reads a .msh file of version 2.x or 4.1, ascii or binary of either byte order: nodes, tetrahedra of order 1 or 2,
/// and the elements of physical groups. If there are physical volumes, tetrahedra outside them are left out, with a
/// notice. Formats: gmsh reference manual, "MSH file format" and "MSH file format version 2 (Legacy)". Throws
/// MeshDefect with the line or byte of the error; FileError if the file cannot be read. Not collective.
SerialMesh read_msh(const std::string& file);

}  // namespace pliant
