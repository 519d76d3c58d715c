/// Rods as tetrahedra of a serial mesh.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <span>

namespace pliant {

/// Appends each rod as a volume, and each of its ends that is held (mesh/rod_chain.hpp). Nodes of rods that have a
/// point in common are one, and those along a curve are the mesh's. Throws InputError at the place of a rod that cannot
/// be, MeshDefect if the mesh has a volume of one of these names. Not collective.
void add_rods(std::span<const AddedRod> rods, std::span<const MeshCurve> curves, SerialMesh& mesh);

}  // namespace pliant
