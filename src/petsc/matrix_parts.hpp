/// The two parts of a distributed sparse matrix (MATMPIAIJ): the columns of this rank, and those of others.
#pragma once

#include "petsc/handle.hpp"

#include <array>
#include <vector>

namespace pliant {

/// The values of both parts, for the time of the object. Not collective.
class MatrixValues {
 public:
  explicit MatrixValues(Mat matrix);
  ~MatrixValues();
  MatrixValues(const MatrixValues&) = delete;
  MatrixValues& operator=(const MatrixValues&) = delete;
  double* operator[](std::size_t part) const { return values_[part]; }

 private:
  std::array<Mat, 2> parts_{};
  std::array<double*, 2> values_{};
};

/// Entries that follow one another in both of two arrays of values.
struct EntryRun {
  PetscInt from = 0, to = 0, count = 0;
};

/// The pattern of one part of a matrix, for the time of the object: columns of each row, ascending. Not collective.
class MatrixRows {
 public:
  MatrixRows(Mat matrix, std::size_t part);
  ~MatrixRows();
  MatrixRows(const MatrixRows&) = delete;
  MatrixRows& operator=(const MatrixRows&) = delete;

  PetscInt size() const { return num_rows_; }
  PetscInt begin(PetscInt row) const { return offsets_[row]; }
  PetscInt end(PetscInt row) const { return offsets_[row + 1]; }
  /// The column of an entry, counted in its part.
  PetscInt local_column(PetscInt entry) const { return columns_[entry]; }
  /// The same, counted in the matrix.
  PetscInt column(PetscInt entry) const {
    return numbers_ != nullptr ? numbers_[columns_[entry]] : first_ + columns_[entry];
  }

  /// The entry of a row with this column, counted in the matrix, which the row has.
  PetscInt entry(PetscInt row, PetscInt in_matrix) const;

  /// Runs of the entries for which wanted(row, entry) holds, which are among those of `to`.
  template <class Wanted>
  std::vector<EntryRun> runs(const MatrixRows& to, const Wanted& wanted) const {
    std::vector<EntryRun> result;
    for (PetscInt row = 0; row < num_rows_; ++row) {
      PetscInt place = to.begin(row);
      for (PetscInt k = begin(row); k < end(row); ++k) {
        if (!wanted(row, k)) continue;
        while (to.column(place) < column(k)) ++place;
        const bool continues = !result.empty() && result.back().from + result.back().count == k &&
                               result.back().to + result.back().count == place;
        if (!continues) result.push_back({k, place, 0});
        ++result.back().count;
      }
    }
    return result;
  }

 private:
  Mat part_ = nullptr;
  PetscInt first_ = 0, num_rows_ = 0;
  const PetscInt *numbers_ = nullptr, *offsets_ = nullptr, *columns_ = nullptr;
};

/// D = the diagonal of A, whose rows all have their diagonal entry. Unlike MatGetDiagonal, which reads rows from their
/// start, this searches by bisection. Not collective.
void get_diagonal(Mat A, Vec D);

/// A flag of each column of both parts of A, from those of its owned rows. A is square. Collective.
std::array<std::vector<char>, 2> flags_of_columns(Mat A, const std::vector<char>& of_rows);

/// A zero matrix with the layout of `like` and these columns, counted in the matrix, of the owned rows: row i has those
/// from offsets[i] on, ascending. Collective.
Handle<Mat> make_zero_matrix(Mat like, const std::vector<PetscInt>& offsets, const std::vector<PetscInt>& columns);

}  // namespace pliant
