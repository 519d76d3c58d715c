/// Prolongations of smoothed aggregation: coarse functions as combinations of the near-null modes of each aggregate.
#pragma once

#include "multigrid/aggregation.hpp"
#include "multigrid/halo.hpp"
#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// Functions on which an elastic body spends little energy (its rigid motions), by node: blocks of `height` x 6, column
/// by column. A function that a body lacks is zero.
struct Modes {
  static constexpr int number = 6;
  int height = 3;
  std::vector<double> values;

  std::size_t block_size() const { return static_cast<std::size_t>(height) * number; }
  const double* block(int node) const { return values.data() + static_cast<std::size_t>(node) * block_size(); }
  double* block(int node) { return values.data() + static_cast<std::size_t>(node) * block_size(); }
};

/// Rows of a prolongation, for own nodes and then for ghosts; columns are numbers of coarse nodes through the ranks.
struct ProlongationRows {
  BlockCsr blocks;  ///< without columns
  std::vector<PetscInt> columns;
  int num_own_columns = 0;  ///< coarse nodes of this rank
};

/// Modes of each aggregate, orthonormal, in place of those of its nodes; what they were in terms of these becomes the
/// modes of the coarse nodes (a QR decomposition by aggregate). Not collective.
Modes orthonormalise(const Aggregates& aggregates, Modes& modes);

/// The rows of a matrix that prolongs nodes of a coarser mesh, with three rows and columns for each node. Collective.
ProlongationRows given_prolongation(Mat P, const Halo& fine);

/// The modes at the coarse nodes of such a prolongation, each of which is a node of the fine mesh too. Not collective.
Modes injected(const Modes& fine, const ProlongationRows& rows, PetscInt first_coarse);

/// (1 - omega D^-1 A) T with omega = 4 / (3 largest), for T of the orthonormal modes. `D`: inverse of the diagonal
/// blocks; `largest`: eigenvalue of D^-1 A. Nodes in no aggregate have no row. Collective.
ProlongationRows smoothed_prolongation(const BlockCsr& A, const Halo& halo, std::span<const float> D, double largest,
                                       const Aggregates& aggregates, const Modes& orthonormal);

}  // namespace pliant
