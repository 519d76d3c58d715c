/// What is wrong with a serial mesh, and what can be put right.
#pragma once

#include "mesh/report.hpp"
#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Drops orphan nodes, turns inverted tetrahedra round, sees straight second-order meshes as first-order ones, and
/// rejects what cannot be put right: nodes that are not finite or coincide, flat tetrahedra, tetrahedra given twice,
/// group names given twice. Afterwards nodes are numbered with the corners first; `num_vertices` of them. Repairs are
/// counted and noticed in `report`. Throws MeshDefect with every reason found. Not collective.
PetscInt repair(SerialMesh& mesh, MeshReport& report);

}  // namespace pliant
