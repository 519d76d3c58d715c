/// W^T B for rows of W that have entries in the same few columns: dense products.
#pragma once

#include "petsc/matrix_parts.hpp"

#include <eigen3/Eigen/Core>
#include <span>
#include <vector>

namespace pliant {

/// Owned rows of a matrix, and the columns, counted in it, in which all of them have entries. Every rank gives the same
/// columns.
struct RowsOfColumns {
  std::vector<PetscInt> rows, columns;
};

/// K += W_g^T B_g for the rows g of W and B; the columns of W_g are the rows of K. PETSc's product of these matrices
/// would take each row of W as a sparse one; those of a mechanism have an entry for each of its degrees of freedom.
class DenseRows {
 public:
  /// W, B and K of type MATMPIAIJ, K with entries for the whole product; only patterns are used. Not collective.
  DenseRows(RowsOfColumns of, Mat W, Mat B, Mat K);

  /// Adds what belongs into rows of this rank; keeps the rest. Not collective.
  void add(const MatrixValues& W, const MatrixValues& B, const MatrixValues& K);
  /// Adds the rest to K, which is assembled afterwards. Not collective.
  void add_far(Mat K) const;

 private:
  struct Place {
    std::size_t part = 0;
    PetscInt entry = -1;  // of the values of this part; -1: none
  };
  struct Entry {
    Place from;
    Eigen::Index row = 0, column = 0;
  };
  struct Run {
    std::size_t part = 0;
    Eigen::Index row = 0;  // of the product
    EntryRun entries;      // from columns of the product to values of K
  };

  void find_columns(Mat B);
  void find_targets(Mat K);

  RowsOfColumns of_;
  std::vector<PetscInt> columns_;   // of the product, as numbers in the matrix; dense ones first
  std::vector<Place> of_W_, of_B_;  // by rows, then columns: all of W, and the dense columns of B
  std::vector<Entry> sparse_;       // of B
  std::vector<Run> runs_;           // of rows of K of this rank
  std::vector<Eigen::Index> far_;   // rows of the product whose rows of K belong to other ranks
  Eigen::Index num_dense_ = 0;
  Eigen::MatrixXd W_, B_, product_;  // W_: a column for each row
};

}  // namespace pliant
