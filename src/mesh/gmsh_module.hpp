/// What Pliant does with libgmsh: a library of its own, loaded when it is first needed. libgmsh and its CAD kernel take
/// more memory and time to load than everything else together, and a run that reads a mesh needs neither.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// What a file of geometry holds: a script of gmsh, solids of a CAD program, or the triangles of a closed surface.
enum class Geometry { script, cad, surface };

struct GmshModule {
  /// Throws MeshDefect. To be called in an `isolated` process.
  SerialMesh (*mesh_geometry)(const MeshSource& source, Geometry kind);
  /// Corners of all triangles of a .stl or .msh, three nodes each, as a mesh without cells. Likewise.
  SerialMesh (*triangle_corners)(const std::string& file);
};

/// Loads the library installed with the program, once. Throws MeshDefect if it is missing.
const GmshModule& gmsh_module();

}  // namespace pliant
