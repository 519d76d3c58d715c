/// From the serial mesh on rank 0 to the DMPlex over all ranks.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// A serial mesh with what the distribution needs; empty but for `groups` on ranks other than 0.
struct MeshParts {
  SerialMesh mesh;             ///< corner nodes first
  PetscInt num_vertices = 0;   ///< corner nodes
  std::vector<PetscInt> part;  ///< rank of each cell
};

/// Builds the DMPlex with its labels, hands the cells to their ranks, refines, and adds the layer of overlap cells.
/// Fills `result.dm`, `geometry_order`, `edge_midpoints`, `vertex_numbers`, `cell_numbers` and the values of
/// `cell_data` (refined cells have their parent's); needs `result.groups` and the names of `result.cell_data` on every
/// rank. Frees the serial mesh on the way. Notices about groups are added on rank 0. Collective.
void distribute(MPI_Comm comm, MeshParts&& parts, int refine, Mesh& result);

}  // namespace pliant
