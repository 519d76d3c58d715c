/// PETSc's matrices of scalars read as blocks of 3 x 3.
#pragma once

#include "base/several.hpp"
#include "multigrid/block_csr.hpp"
#include "multigrid/halo.hpp"
#include "petsc/handle.hpp"

#include <optional>
#include <vector>

namespace pliant {

/// Blocks of a matrix in double precision, in the order of those of a BlockCsr.
class BlockSource {
 public:
  virtual ~BlockSource() = default;
  /// Writes the k-th block of a row, column by column.
  virtual void read(int row, std::size_t k, double* block) const = 0;
};

/// The rows of a rank of an AIJ matrix, each node with three rows and columns. Constraints leave blocks of which only
/// some entries are stored; the others are zero. Refers to the matrix's arrays, which must not be assembled anew
/// meanwhile.
class MatrixBlocks : public BlockSource {
 public:
  /// Nothing if the rows or columns of a rank cannot be grouped by three. Collective.
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
  /// y = K x for the own entries of several vectors at once, unscaled. x has ghosts. Not collective.
  void multiply(std::span<const SeveralDoubles> x, std::span<SeveralDoubles> y) const;

 private:
  /// A matrix of one rank.
  class Part {
   public:
    /// `entries`: the entry that each column belongs to, ascending, three for a node; empty: the column itself.
    void open(Mat of, PetscInt num_rows, std::vector<PetscInt> entries);
    void close();
    bool is_open() const { return matrix_ != nullptr; }
    double largest(PetscInt num_rows) const;
    std::size_t num_blocks(int row) const;
    /// The node of the k-th block of a row.
    int node(int row, std::size_t k) const;
    void read(int row, std::size_t k, double factor, double* block) const;
    /// sums += three rows times x, in which the entries of this part follow `first`.
    void add_products(int row, const SeveralDoubles* first, SeveralDoubles* sums) const;

   private:
    PetscInt entry(PetscInt column) const { return entries_.empty() ? column : entries_[column]; }
    bool is_of_blocks(PetscInt num_rows) const;
    void find_blocks(PetscInt num_rows);

    Mat matrix_ = nullptr;
    const PetscInt* offsets_ = nullptr;
    const PetscInt* columns_ = nullptr;
    const PetscScalar* values_ = nullptr;
    std::vector<PetscInt> entries_;
    std::vector<int> begins_, nodes_;  // of the blocks of each row; empty where all blocks are whole
  };
  MatrixBlocks() = default;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int num_rows_ = 0;
  Part own_, others_;  // columns of this rank's nodes, and of ghosts
  std::vector<PetscInt> ghosts_;
  double factor_ = 1.0;
};

}  // namespace pliant
