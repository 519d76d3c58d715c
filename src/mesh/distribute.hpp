/// From the serial mesh on rank 0 to the DMPlex over all ranks.
#pragma once

#include "mesh/serial_mesh.hpp"

namespace pliant {

/// Where the mesh is before its distribution.
struct MeshParts {
  enum class Held {
    on_root,   ///< rank 0 holds all of it; METIS partitions it before the distribution
    in_blocks  ///< each rank holds one block of the cells and one of the nodes, in rank order; it is partitioned in
               ///< parallel
  };
  Held held = Held::on_root;
  SerialMesh mesh;  ///< corner nodes first; for in_blocks: cells and groups use the node numbers of the whole mesh
  PetscInt num_vertices = 0;      ///< corner nodes that this rank holds
  PetscInt first_cell = 0;        ///< for in_blocks: number of cells on lower ranks
  std::vector<PetscInt> part;     ///< on rank 0: the rank assigned to each cell
  std::vector<MeshCurve> curves;  ///< on rank 0: Mesh::curves
};

/// Builds the DMPlex with its labels, sends the cells to their ranks, refines, and adds the layer of overlap cells.
/// Fills `result.dm`, `geometry_order`, `edge_midpoints`, `vertex_numbers`, `cell_numbers` and the values of
/// `cell_data` (refined cells inherit their parent's); needs `result.groups` and the names of `result.cell_data` on
/// every rank. Frees the serial mesh on the way. Notices about groups are added on rank 0. Collective.
void distribute(MPI_Comm comm, MeshParts&& parts, int refine, Mesh& result);

}  // namespace pliant
