/// Finds the defects of a serial mesh, and repairs what can be repaired.
#pragma once

#include "mesh/report.hpp"
#include "mesh/serial_mesh.hpp"

#include <span>
#include <string>

namespace pliant {

/// Drops orphan nodes, reorients inverted tetrahedra, converts straight second-order meshes to first order, and rejects
/// what cannot be repaired: nodes that are not finite or coincide, flat tetrahedra, duplicate tetrahedra, duplicate
/// group names. Afterwards the `num_vertices` corner nodes are numbered first. Repairs are counted and described in
/// `report`. Nodes may coincide with those of the `meeting_parts`, given by name or number, and with those of the
/// frames of `rods`. Throws MeshDefect with every reason found. Not collective.
PetscInt repair(SerialMesh& mesh, std::span<const std::string> meeting_parts, std::span<const AddedRod> rods,
                MeshReport& report);

}  // namespace pliant
