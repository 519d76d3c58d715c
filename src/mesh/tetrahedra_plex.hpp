/// Builds a DMPlex of tetrahedra with all their facets and edges.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// The interpolated DMPlex of the cells of each rank by itself (all on rank 0, or one rank), first-order geometry:
/// cells, vertices, facets, edges. Cells and vertices have the mesh's order; facets and edges are numbered as the cells
/// use them. The vertices of a cell's closure have the orientation of the mesh's. Equivalent to DMPlexInterpolate, in a
/// tenth of the time. Collective.
Handle<DM> make_tetrahedra_plex(MPI_Comm comm, const SerialMesh& mesh, PetscInt num_vertices);

}  // namespace pliant
