/// Reads meshes as they are, and geometry after gmsh has meshed it.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Reads `source.file` on this rank alone; meshes it with gmsh if it is geometry, and frees all memory of gmsh.
///
/// * .msh (2.2, 4.1; ascii, binary): as it is; a `size` is an error.
/// * .inp, .vtk, .vtu, .med, .bdf, .nas, .unv, .mesh: likewise (mesh/formats).
/// * .geo: run by gmsh's own interpreter. A `size` overrides every size of the file (points, fields, curvature,
///   and with the OpenCASCADE kernel transfinite divisions; those of the built-in kernel and its extrusion layers stay,
///   with a notice).
/// * .step, .stp: lengths in the file's own unit, converted to metres. .brep: lengths as they are.
/// * .stl: lengths as they are; the surface must be closed. Its triangles bound the mesh unless `size` asks for new
///   ones. Shells inside others are cavities.
/// Throws MeshDefect, or FileError if the file cannot be opened. Not collective.
SerialMesh import_mesh(const MeshSource& source);

}  // namespace pliant
