/// From the mesh that gmsh holds to ours.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Nodes, tetrahedra and physical groups of gmsh's current model, by MeshCollector's rules. Throws MeshDefect.
SerialMesh extract_mesh();

}  // namespace pliant
