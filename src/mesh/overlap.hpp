/// Ghost cells around the cells of a rank, and the owners of all points.
#pragma once

#include "mesh/cell_block.hpp"

namespace pliant {

/// The cells of a rank, and after them all cells of other ranks that share a vertex with one of these.
struct OverlappingCells {
  CellBlock block;
  PetscInt num_own = 0;
  std::vector<int> ghost_ranks;       ///< the owner of each ghost cell
  std::vector<PetscInt> ghost_cells;  ///< its index among the owner's cells
  std::vector<PetscInt> border;       ///< own cells that are ghosts elsewhere
};

/// `own`: with vertices. Collective.
OverlappingCells with_ghosts(MPI_Comm comm, CellBlock own);

/// Gives every point of the DMPlex of these cells an owner: of cells the rank that has them as its own, of other points
/// one of the ranks that have cells around it, spread evenly over them. Fills the point SF. Collective.
void set_owners(MPI_Comm comm, DM dm, const OverlappingCells& cells);

}  // namespace pliant
