/// Uniform refinement of cells before their distribution is complete.
#pragma once

#include "mesh/cell_block.hpp"

namespace pliant {

/// Cuts each cell into eight: four at its corners, four around the edge from the middle of edge 01 to that of edge 23.
/// Child k of cell c has the number 8 c + k; vertices are numbered by ascending numbers of the ends of the edge on
/// which they lie, those of the coarse mesh as an edge from themselves to themselves. Children have the values of their
/// cell, and the groups of the part of it in which they lie. Straight edges only. Collective.
CellBlock refined(MPI_Comm comm, const CellBlock& block);

}  // namespace pliant
