/// From the serial mesh on rank 0 to the DMPlex over all ranks.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// The mesh before its distribution.
struct MeshParts {
  enum class Held {
    on_root,   ///< rank 0 has all of it, METIS has cut it
    in_blocks  ///< each rank has a block of the cells and one of the nodes, rank after rank; it is cut in parallel
  };
  Held held = Held::on_root;
  SerialMesh mesh;             ///< corner nodes first; in blocks: the cells and groups count the nodes of all ranks
  PetscInt num_vertices = 0;   ///< corner nodes that this rank holds
  PetscInt first_cell = 0;     ///< in blocks: cells that ranks before this one hold
  std::vector<PetscInt> part;  ///< on rank 0: rank of each cell
};

/// Builds the DMPlex with its labels, hands the cells to their ranks, refines, and adds the layer of overlap cells.
/// Fills `result.dm`, `geometry_order`, `edge_midpoints`, `vertex_numbers`, `cell_numbers` and the values of
/// `cell_data` (refined cells have their parent's); needs `result.groups` and the names of `result.cell_data` on every
/// rank. Frees the serial mesh on the way. Notices about groups are added on rank 0. Collective.
void distribute(MPI_Comm comm, MeshParts&& parts, int refine, Mesh& result);

}  // namespace pliant
