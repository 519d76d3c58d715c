/// PETSc's matrices of scalars read as blocks of 3 x 3.
#pragma once

#include "multigrid/block_csr.hpp"
#include "multigrid/halo.hpp"
#include "petsc/handle.hpp"

#include <optional>

namespace pliant {

/// Blocks of a matrix in double precision, in the order of those of a BlockCsr.
class BlockSource {
 public:
  virtual ~BlockSource() = default;
  /// Writes the k-th block of a row, column by column.
  virtual void read(int row, std::size_t k, double* block) const = 0;
};

/// The rows of a rank of an AIJ matrix, each node with three rows and columns. Refers to the matrix's arrays, which
/// must not be assembled anew meanwhile.
class MatrixBlocks : public BlockSource {
 public:
  /// Nothing if the matrix is not made of whole blocks of 3 x 3, on any rank. Collective.
  static std::optional<MatrixBlocks> of(Mat K);
  MatrixBlocks(MatrixBlocks&&) noexcept;
  MatrixBlocks& operator=(MatrixBlocks&&) = delete;
  ~MatrixBlocks() override;

  int num_rows() const { return num_rows_; }
  Halo make_halo() const;
  /// The pattern, without values. Columns count as the halo does.
  BlockCsr pattern() const;
  void read(int row, std::size_t k, double* block) const override;
  /// Divides what is read from now on by the largest entry, which is returned; 1 if all are zero. Collective.
  double scale_to_one();

 private:
  /// A matrix of one rank.
  struct Part {
    Mat matrix = nullptr;
    const PetscInt* offsets = nullptr;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    void open(Mat of);
    void close();
    bool is_of_blocks(PetscInt num_rows) const;
    double largest(PetscInt num_rows) const;
    std::size_t num_blocks(int row) const {
      return static_cast<std::size_t>(offsets[3 * row + 1] - offsets[3 * row]) / 3;
    }
  };
  MatrixBlocks() = default;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int num_rows_ = 0;
  Part own_, others_;  // columns of this rank's nodes, and of ghosts
  std::vector<PetscInt> ghosts_;
  double factor_ = 1.0;
};

}  // namespace pliant
