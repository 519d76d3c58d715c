/// Tetrahedra with all their facets and edges as a DMPlex.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// The interpolated DMPlex of the cells of each rank by itself (all on rank 0, or one rank), first-order geometry:
/// cells, vertices, facets, edges, each numbered from 0 as the mesh has it, or as cells come to it. Vertices of a
/// cell's closure come in an order of the same orientation as the mesh's. Does what DMPlexInterpolate does, in a tenth
/// of the time. Collective.
Handle<DM> make_tetrahedra_plex(MPI_Comm comm, const SerialMesh& mesh, PetscInt num_vertices);

}  // namespace pliant
