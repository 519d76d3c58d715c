/// The partition of a mesh that no rank holds as a whole.
#pragma once

#include "mesh/cell_block.hpp"

namespace pliant {

/// The rank for each cell of the block, by PTScotch or ParMETIS, whichever PETSc has. PTScotch is not reproducible: its
/// partition depends on the order in which messages arrive. Where PETSc has neither, cells stay where they are: the
/// file's order along a space-filling curve gives compact parts too. Collective.
std::vector<PetscInt> partition_in_parallel(MPI_Comm comm, const CellBlock& block);

}  // namespace pliant
