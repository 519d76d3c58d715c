/// Reads closed surfaces of triangles, the shapes of rigid obstacles; nothing is meshed.
#pragma once

#include "mesh/mesh.hpp"

#include <array>
#include <vector>

namespace pliant {

/// Triangles whose corners are anticlockwise seen from outside; every edge belongs to two of them.
struct SurfaceMesh {
  std::vector<std::array<double, 3>> nodes;        ///< [m]
  std::vector<std::array<PetscInt, 3>> triangles;  ///< numbers of nodes
};

/// The surface of triangles given by their corners, nine numbers each [1/scale m]. Nodes at the same place are merged.
/// Triangles that face inwards as a whole are reoriented. Throws MeshDefect if there are none, or if the surface is not
/// closed, is flat, or has a corner that is not finite. Not collective.
SurfaceMesh closed_surface(const std::vector<double>& corners, double scale);

/// Reads the triangles of `source.file` (.stl, or the triangles of a .msh) with gmsh on rank 0, for all ranks; ignores
/// `size` and `refine`. Throws InputError at `source.where` where closed_surface throws. Collective.
SurfaceMesh read_surface(MPI_Comm comm, const MeshSource& source);

}  // namespace pliant
