/// The Hessian in the unknowns that constraints leave: a sparse product with matrices close to the identity.
#pragma once

#include "energy/equation/dense_rows.hpp"
#include "petsc/matrix_parts.hpp"

#include <array>
#include <vector>

namespace pliant {

/// K = W^T A J, where J and W have the rows of the identity but for those of tied entries, which are few. Only the
/// entries of A in rows or columns of tied entries, A', are multiplied; all others are copied:
///
///   K = (A - A') + W^T A' J.
///
/// PETSc's products of the whole matrices would cost as much as the assembly of A.
class ConstrainedProduct {
 public:
  /// All of type MATMPIAIJ with the same layout; only patterns are used, that of A is symmetric. W and J may be one
  /// matrix. `is_tied`: one flag per leading owned row of J and W; the others are those of the identity. `is_slave`:
  /// likewise, rows and columns of K that are zero but for the diagonal. `dense`: rows of W without other entries than
  /// zero. J and W outlive the object. Collective.
  ConstrainedProduct(Mat A, Mat W, Mat J, const std::vector<char>& is_tied, const std::vector<char>& is_slave,
                     std::vector<RowsOfColumns> dense = {});

  /// A zero matrix with the pattern of K. Collective.
  Handle<Mat> make() const;
  /// Sets K, a matrix of make() for an A of this pattern, from the values of A, J and W. The diagonal entries of slaves
  /// are the magnitudes of those of A; where these are zero, that of the largest. Collective.
  void set(Mat A, Mat K);
  /// Puts those entries of the diagonal of K that may differ from those of A into D. Not collective.
  void put_diagonal(Mat K, Vec D) const;

 private:
  /// One list for each part of a matrix: the columns of this rank, and those of other ranks.
  using Runs = std::array<std::vector<EntryRun>, 2>;

  /// A part of the entries of a matrix.
  struct Part {
    Handle<Mat> matrix;
    Runs from_whole;
  };

  void make_near(Mat A);
  /// What is not in columns of slaves, nor in these rows.
  Part part_of(Mat matrix, const std::vector<char>& is_left_out) const;
  /// W^T A' J, of the parts that are in use.
  void multiply(MatReuse reuse);
  void make_pattern(Mat A);
  Runs K_from_product() const;
  void find_runs_from(Mat A);
  void find_diagonal(Mat A);
  void set_diagonal_of_slaves(const MatrixValues& A, const MatrixValues& K) const;

  Mat W_, J_;
  bool has_two_steps_;  // or W = J, and no rows are dense
  std::vector<char> is_tied_row_, is_slave_row_;
  std::array<std::vector<char>, 2> is_tied_column_;  // per column of each part of A
  Handle<Mat> near_;                                 // A'
  Part J_part_, W_part_;                             // W without dense rows
  Handle<Mat> transposed_, near_times_J_, product_;
  std::vector<DenseRows> dense_;
  Handle<Mat> pattern_;  // of K
  Runs near_from_A_, K_from_A_, K_from_product_;
  Runs K_from_whole_product_;        // with dense rows
  std::vector<EntryRun> of_slaves_;  // from the diagonal of A to that of K
  std::vector<EntryRun> changed_;    // from the diagonal of K to entries of a vector
};

}  // namespace pliant
