/// Copies the mesh that gmsh holds to Pliant's SerialMesh.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Nodes, tetrahedra and physical groups of gmsh's current model, selected as MeshCollector does. Throws MeshDefect.
SerialMesh extract_mesh();

}  // namespace pliant
