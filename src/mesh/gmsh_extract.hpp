/// From the mesh that gmsh holds to ours.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// The tetrahedra of gmsh's current model (those of the physical volumes if there are any), every node of the model,
/// and the physical groups. Throws MeshDefect if there are no tetrahedra, or other volume elements than first- or
/// second-order ones.
SerialMesh extract_mesh();

}  // namespace pliant
