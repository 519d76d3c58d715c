/// A distributed sparse matrix of 3 x 3 node blocks that cells write into directly, through positions found once.
#pragma once

#include "fem/layout.hpp"
#include "petsc/handle.hpp"
#include "petsc/near_null_space.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace pliant {

/// Nodes of other ranks that no cell of this rank has, and which nodes couple in addition to those that share a cell.
struct FarCouplings {
  std::vector<PetscInt> globals;                     ///< global numbers of the far nodes, ascending
  std::vector<std::pair<PetscInt, PetscInt>> pairs;  ///< owned node, local node; far nodes count after the layout's
};

/// The sparsity pattern "nodes that share a cell", with further couplings where there are any, and where the block of a
/// pair of nodes lies in it.
/// A rank holds the rows of its owned nodes, split as PETSc's MPIAIJ does: the block of owned columns, and the rest.
class BlockPattern {
 public:
  explicit BlockPattern(const NodeLayout& layout);  ///< throws InputError for more blocks than integers count
  BlockPattern(const NodeLayout& layout, const FarCouplings& far);

  /// Block number of (row node, column node): >= 0 counts blocks of the owned columns, < 0 means -1 - (number among
  /// the others). The row must be owned, and the pair in the pattern.
  std::int32_t block(PetscInt row_node, PetscInt column_node) const;
  bool contains(PetscInt row_node, PetscInt column_node) const;
  /// The global number of a local node; far nodes count after the ghosts of the layout.
  PetscInt global_node(PetscInt local_node) const {
    return local_node < num_owned_nodes_ ? first_global_node_ + local_node
                                         : other_globals_[local_node - num_owned_nodes_];
  }
  PetscInt num_owned_nodes() const { return num_owned_nodes_; }

  struct Rows {
    std::vector<PetscInt> offsets;  ///< blocks before each owned node's row, num_owned_nodes + 1
    std::vector<PetscInt> nodes;    ///< local column nodes, ascending in global number within a row
  };
  const Rows& diagonal() const { return diagonal_; }
  const Rows& off_diagonal() const { return off_diagonal_; }
  /// The block of each owned node with itself.
  std::span<const PetscInt> own_blocks() const { return own_blocks_; }

 private:
  /// Where the column is, or would be, among the blocks of its part.
  std::vector<PetscInt>::const_iterator find(const Rows& part, PetscInt row_node, PetscInt column_node) const;

  Rows diagonal_;
  Rows off_diagonal_;
  std::vector<PetscInt> own_blocks_;
  PetscInt num_owned_nodes_, first_global_node_;
  std::vector<PetscInt> other_globals_;  // of ghosts, then of far nodes
};

/// Write access to the values of a matrix made by `make_matrix`, until `finish` or the end of the scope.
class BlockWriter {
 public:
  BlockWriter(const BlockPattern& pattern, Mat matrix);
  ~BlockWriter();
  BlockWriter(const BlockWriter&) = delete;
  BlockWriter& operator=(const BlockWriter&) = delete;

  /// Start of the 3 x 3 block `number` of the owned row `node`, and the distance between its rows.
  struct Block {
    double* values;
    PetscInt stride;
  };
  Block block(PetscInt node, std::int32_t number) const { return row(node).block(number); }

  /// The blocks of one row, for loops over them.
  struct Row {
    // Where the rows' blocks start, if each block before took three entries.
    double* diagonal;
    double* off_diagonal;
    PetscInt diagonal_stride, off_diagonal_stride;

    Block block(std::int32_t number) const {
      if (number >= 0) return {diagonal + 3 * std::ptrdiff_t{number}, diagonal_stride};
      return {off_diagonal + 3 * (-1 - std::ptrdiff_t{number}), off_diagonal_stride};
    }
  };
  Row row(PetscInt node) const {
    const PetscInt before = diagonal_offsets_[node], before_off = off_diagonal_offsets_[node];
    return {diagonal_ + 6 * std::ptrdiff_t{before}, off_diagonal_ + 6 * std::ptrdiff_t{before_off},
            3 * (diagonal_offsets_[node + 1] - before), 3 * (off_diagonal_offsets_[node + 1] - before_off)};
  }
  void zero();
  /// Adds a block, by rows, where its place has not been found once and for all; nothing in rows of other ranks.
  void add(PetscInt row_node, PetscInt column_node, std::span<const double, 9> block) const;
  /// Adds the values of a matrix whose pattern is a part of this one.
  void add(const BlockPattern& pattern, Mat matrix) const;
  /// The diagonal of the matrix, xyz per owned node.
  void copy_diagonal(std::span<double> diagonal) const;
  /// Ends the access and declares the matrix changed and assembled. Collective.
  void finish();

 private:
  const BlockPattern& pattern_;
  Mat matrix_, diagonal_matrix_ = nullptr, off_diagonal_matrix_ = nullptr;
  double* diagonal_ = nullptr;
  double* off_diagonal_ = nullptr;
  const PetscInt* diagonal_offsets_;
  const PetscInt* off_diagonal_offsets_;
  std::size_t diagonal_size_, off_diagonal_size_;
};

/// A zero MPIAIJ matrix (block size 3, declared symmetric) of the pattern. Collective.
Handle<Mat> make_matrix(const NodeLayout& layout, const BlockPattern& pattern);

/// Three translations and three rotations of the reference configuration, zero on prescribed entries (flags as in
/// RowElimination): the near-null space of a stiffness. Multigrid represents them on coarse levels. Collective.
std::vector<Handle<Vec>> rigid_body_modes(const NodeLayout& layout, std::span<const char> is_prescribed,
                                          std::span<const double> displacements = {});

/// Symmetric elimination of prescribed entries from a matrix of the pattern: rows and columns to zero, diagonal to a
/// given value.
class RowElimination {
 public:
  /// `is_prescribed`: one flag per local entry (3 per local node, ghosts and the pattern's far nodes included).
  RowElimination(const NodeLayout& layout, const BlockPattern& pattern, std::span<const char> is_prescribed);
  /// Not collective; `diagonal` should be of the size of the other diagonal entries.
  void apply(const BlockWriter& writer, double diagonal) const;

 private:
  struct Entry {
    PetscInt node;
    std::int32_t block;
    std::uint16_t mask;  ///< bit 3 i + j: entry (i, j) of the block goes
    bool on_diagonal;
  };
  std::vector<Entry> entries_;
};

}  // namespace pliant
