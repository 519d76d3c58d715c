/// Free shells, whose triangles bound no tetrahedron, as tetrahedra of a serial mesh.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <span>

namespace pliant {

/// Appends each shell as a volume: a tetrahedron on each of its triangles, with a new node, its apex, which has a
/// higher number than the triangle's corners. The apex lies on the side that the triangle's normal points away from.
/// Neighbouring triangles get one orientation: that of the first, or, where they enclose a volume, the one whose
/// normals point into it, or that of the facets of bodies next to them in a physical surface. Throws InputError at the
/// place of a shell that cannot be, MeshDefect if the mesh has a volume of one of these names. Not collective.
void add_shells(std::span<const AddedShell> shells, SerialMesh& mesh);

}  // namespace pliant
