/// Aggregates: groups of neighbouring nodes that a coarser level of multigrid takes for one.
#pragma once

#include "multigrid/block_csr.hpp"

#include <vector>

namespace pliant {

struct Aggregates {
  std::vector<int> of_node;  ///< of each own node; -1: of none
  int number = 0;
};

/// Groups the rows of a matrix: a node with all its neighbours where these are free, then the rest to the neighbour to
/// which they are bound most strongly (Vanek, Mandel & Brezina 1996, "Algebraic multigrid by smoothed aggregation for
/// second and fourth order elliptic problems", 5.1). Only own nodes are neighbours; one without neighbours is in no
/// aggregate, as a level's smoother solves for it. Not collective.
Aggregates aggregate(const BlockCsr& A);

}  // namespace pliant
