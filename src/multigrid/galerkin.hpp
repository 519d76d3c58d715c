/// Galerkin's product P^T A P of matrices of blocks, whose pattern stays.
#pragma once

#include "multigrid/matrix_blocks.hpp"
#include "multigrid/prolongation.hpp"

#include <vector>

namespace pliant {

/// The matrix of a coarser level. Sums are taken in double precision: those of a body's rigid motions cancel.
///
/// Invariant: `sums_` has a block for each of the own rows, and then for each row of other ranks to which this one
/// contributes.
class GalerkinProduct : public BlockSource {
 public:
  /// `A`: the pattern of the finer matrix. Collective.
  GalerkinProduct(const BlockCsr& A, const Halo& fine, ProlongationRows rows);

  /// P, for own nodes and ghosts of the finer level; columns count as `coarse` does.
  const BlockCsr& prolongation() const { return P_; }
  const Halo& coarse() const { return coarse_; }
  /// Takes another prolongation of the same pattern, computed in the same order.
  void take(const ProlongationRows& rows);
  /// The pattern of the coarse matrix, without values.
  BlockCsr pattern() const;

  /// Computes the product for the present values of the finer matrix. Collective.
  void compute(const BlockCsr& A, const BlockSource& values);
  void read(int row, std::size_t k, double* block) const override;

  /// Frees the sums, which are needed only until the next level has been computed.
  void forget_sums() { sums_ = {}; }

 private:
  void make_pattern(const BlockCsr& A, const Halo& fine, const std::vector<PetscInt>& columns, int num_own);
  void plan_exchange();
  std::size_t block_size() const { return static_cast<std::size_t>(P_.width) * static_cast<std::size_t>(P_.width); }
  template <int height, int width>
  void add_products(const BlockCsr& A, const BlockSource& values);
  std::size_t find(int row, int column) const;
  void complete_diagonal();

  BlockCsr P_;
  Halo coarse_;
  std::vector<int> offsets_, columns_;  // rows of coarse_, own ones and ghosts
  std::vector<double> sums_;
  std::vector<int> num_sent_, num_received_;  // blocks
  std::vector<std::size_t> received_;         // which block each one received is added to
};

}  // namespace pliant
