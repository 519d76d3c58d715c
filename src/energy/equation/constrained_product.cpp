#include "energy/equation/constrained_product.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pliant {
namespace {

void assemble(Mat matrix) {
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

/// Copies entries from one matrix to another; the others of that one keep their values. Collective.
void copy(const std::array<std::vector<EntryRun>, 2>& runs, Mat from, Mat to) {
  {
    const MatrixValues source(from), target(to);
    for (std::size_t p = 0; p < 2; ++p) {
      for (const EntryRun& run : runs[p]) std::copy_n(source[p] + run.from, run.count, target[p] + run.to);
    }
  }
  assemble(to);
}

/// A flag of each owned row, set if it has no entries.
std::vector<char> empty_rows(Mat matrix) {
  const MatrixRows own(matrix, 0), others(matrix, 1);
  std::vector<char> result;
  for (PetscInt row = 0; row < own.size(); ++row) {
    result.push_back(own.begin(row) == own.end(row) && others.begin(row) == others.end(row) ? 1 : 0);
  }
  return result;
}

}  // namespace

ConstrainedProduct::ConstrainedProduct(Mat A, Mat W, Mat J, const std::vector<char>& is_tied,
                                       const std::vector<char>& is_slave, std::vector<RowsOfColumns> dense)
    : W_(W), J_(J), has_two_steps_(W != J || !dense.empty()) {
  PetscInt num_rows = 0;
  check(MatGetLocalSize(A, &num_rows, nullptr));
  const auto of_all_rows = [&](std::vector<char> flags) {
    flags.resize(static_cast<std::size_t>(num_rows), 0);
    return flags;
  };
  is_tied_row_ = of_all_rows(is_tied);
  is_slave_row_ = of_all_rows(is_slave);
  is_tied_column_ = flags_of_columns(A, is_tied_row_);
  make_near(A);
  const std::vector<char> is_far = empty_rows(near_.get());
  J_part_ = part_of(J_, is_far);
  if (has_two_steps_) W_part_ = part_of(W_, is_far);
  multiply(MAT_INITIAL_MATRIX);
  make_pattern(A);
  K_from_whole_product_ = K_from_product();
  find_diagonal(A);
  if (!dense.empty()) {
    std::vector<char> is_dense = is_far;
    for (const RowsOfColumns& group : dense) {
      for (const PetscInt row : group.rows) is_dense[static_cast<std::size_t>(row)] = 1;
    }
    W_part_ = part_of(W_, is_dense);
    multiply(MAT_INITIAL_MATRIX);
    for (RowsOfColumns& rows : dense) {
      dense_.emplace_back(std::move(rows), W_, near_times_J_.get(), pattern_.get());
    }
  }
  K_from_product_ = K_from_product();
  find_runs_from(A);
}

ConstrainedProduct::Part ConstrainedProduct::part_of(Mat matrix, const std::vector<char>& is_left_out) const {
  const auto is_slave_column = flags_of_columns(matrix, is_slave_row_);
  const MatrixRows own(matrix, 0), others(matrix, 1);
  const std::array parts{&own, &others};
  const auto is_wanted = [&](std::size_t p) {
    return [&, p](PetscInt row, PetscInt k) {
      return !is_left_out[static_cast<std::size_t>(row)] &&
             !is_slave_column[p][static_cast<std::size_t>(parts[p]->local_column(k))];
    };
  };
  std::vector<PetscInt> offsets{0}, columns;
  for (PetscInt row = 0; row < own.size(); ++row) {
    const auto first = static_cast<std::ptrdiff_t>(columns.size());
    for (std::size_t p = 0; p < 2; ++p) {
      for (PetscInt k = parts[p]->begin(row); k < parts[p]->end(row); ++k) {
        if (is_wanted(p)(row, k)) columns.push_back(parts[p]->column(k));
      }
    }
    std::sort(columns.begin() + first, columns.end());
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  Part result{make_zero_matrix(matrix, offsets, columns), {}};
  for (std::size_t p = 0; p < 2; ++p) {
    result.from_whole[p] = parts[p]->runs(MatrixRows(result.matrix.get(), p), is_wanted(p));
  }
  return result;
}

// Rows of K: the entries that are copied, those of the product, and the diagonal.
void ConstrainedProduct::make_pattern(Mat A) {
  std::vector<PetscInt> offsets{0}, columns, row_of_K;
  PetscInt first = 0;
  check(MatGetOwnershipRange(A, &first, nullptr));
  const MatrixRows own(A, 0), others(A, 1), own_product(product_.get(), 0), others_product(product_.get(), 1);
  const std::array of_A{&own, &others}, of_product{&own_product, &others_product};
  for (PetscInt row = 0; row < own.size(); ++row) {
    row_of_K.assign(1, first + row);
    for (std::size_t p = 0; p < 2; ++p) {
      for (PetscInt k = of_A[p]->begin(row); k < of_A[p]->end(row); ++k) {
        const auto column = static_cast<std::size_t>(of_A[p]->local_column(k));
        if (!is_tied_row_[static_cast<std::size_t>(row)] && !is_tied_column_[p][column])
          row_of_K.push_back(of_A[p]->column(k));
      }
      for (PetscInt k = of_product[p]->begin(row); k < of_product[p]->end(row); ++k)
        row_of_K.push_back(of_product[p]->column(k));
    }
    std::ranges::sort(row_of_K);
    row_of_K.erase(std::unique(row_of_K.begin(), row_of_K.end()), row_of_K.end());
    columns.insert(columns.end(), row_of_K.begin(), row_of_K.end());
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  pattern_ = make_zero_matrix(J_, offsets, columns);
}

ConstrainedProduct::Runs ConstrainedProduct::K_from_product() const {
  Runs runs;
  for (std::size_t p = 0; p < 2; ++p) {
    const MatrixRows of_product(product_.get(), p), of_K(pattern_.get(), p);
    runs[p] = of_product.runs(of_K, [](PetscInt, PetscInt) { return true; });
  }
  return runs;
}

void ConstrainedProduct::find_runs_from(Mat A) {
  for (std::size_t p = 0; p < 2; ++p) {
    const MatrixRows of_A(A, p), near(near_.get(), p), of_K(pattern_.get(), p);
    const auto is_near = [&](PetscInt row, PetscInt k) {
      return is_tied_row_[static_cast<std::size_t>(row)] ||
             is_tied_column_[p][static_cast<std::size_t>(of_A.local_column(k))];
    };
    near_from_A_[p] = of_A.runs(near, is_near);
    K_from_A_[p] = of_A.runs(of_K, [&](PetscInt row, PetscInt k) { return !is_near(row, k); });
  }
}

void ConstrainedProduct::find_diagonal(Mat A) {
  const MatrixRows of_A(A, 0), of_K(pattern_.get(), 0);
  const std::vector<char> is_of_A_alone = empty_rows(product_.get());
  PetscInt first = 0;
  check(MatGetOwnershipRange(A, &first, nullptr));
  for (PetscInt row = 0; row < of_K.size(); ++row) {
    const auto i = static_cast<std::size_t>(row);
    if (is_of_A_alone[i] && !is_tied_row_[i] && !is_slave_row_[i]) continue;
    const PetscInt entry = of_K.entry(row, first + row);
    changed_.push_back({entry, row, 1});
    if (is_slave_row_[i]) of_slaves_.push_back({of_A.entry(row, first + row), entry, 1});
  }
}

void ConstrainedProduct::make_near(Mat A) {
  std::vector<PetscInt> offsets{0}, columns;
  const MatrixRows own(A, 0), others(A, 1);
  const std::array of_A{&own, &others};
  for (PetscInt row = 0; row < own.size(); ++row) {
    const auto first = static_cast<std::ptrdiff_t>(columns.size());
    for (std::size_t p = 0; p < 2; ++p) {
      for (PetscInt k = of_A[p]->begin(row); k < of_A[p]->end(row); ++k) {
        const auto column = static_cast<std::size_t>(of_A[p]->local_column(k));
        if (is_tied_row_[static_cast<std::size_t>(row)] || is_tied_column_[p][column])
          columns.push_back(of_A[p]->column(k));
      }
    }
    std::sort(columns.begin() + first, columns.end());
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  near_ = make_zero_matrix(A, offsets, columns);
}

void ConstrainedProduct::multiply(MatReuse reuse) {
  Mat product = product_.get(), transposed = transposed_.get(), with_J = near_times_J_.get();
  const bool is_there = reuse == MAT_REUSE_MATRIX;
  if (!has_two_steps_) {
    check(MatPtAP(near_.get(), J_part_.matrix.get(), reuse, PETSC_DEFAULT, is_there ? &product : product_.out()));
    return;
  }
  // MatTransposeMatMult of these matrices would put its entries one by one.
  check(MatTranspose(W_part_.matrix.get(), reuse, is_there ? &transposed : transposed_.out()));
  check(MatMatMult(near_.get(), J_part_.matrix.get(), reuse, PETSC_DEFAULT, is_there ? &with_J : near_times_J_.out()));
  check(MatMatMult(transposed_.get(), near_times_J_.get(), reuse, PETSC_DEFAULT, is_there ? &product : product_.out()));
}

Handle<Mat> ConstrainedProduct::make() const {
  Handle<Mat> K;
  check(MatDuplicate(pattern_.get(), MAT_DO_NOT_COPY_VALUES, K.out()));
  return K;
}

void ConstrainedProduct::set(Mat A, Mat K) {
  copy(near_from_A_, A, near_.get());
  copy(J_part_.from_whole, J_, J_part_.matrix.get());
  if (has_two_steps_) copy(W_part_.from_whole, W_, W_part_.matrix.get());
  multiply(MAT_REUSE_MATRIX);
  {
    const MatrixValues of_A(A), of_product(product_.get()), to(K);
    for (std::size_t p = 0; p < 2; ++p) {
      for (const EntryRun& run : K_from_whole_product_[p]) std::fill_n(to[p] + run.to, run.count, 0.0);
      for (const EntryRun& run : K_from_A_[p]) std::copy_n(of_A[p] + run.from, run.count, to[p] + run.to);
      for (const EntryRun& run : K_from_product_[p]) {
        for (PetscInt k = 0; k < run.count; ++k) to[p][run.to + k] += of_product[p][run.from + k];
      }
    }
    if (!dense_.empty()) {
      const MatrixValues of_W(W_), of_near_times_J(near_times_J_.get());
      for (DenseRows& rows : dense_) rows.add(of_W, of_near_times_J, to);
    }
  }
  for (const DenseRows& rows : dense_) rows.add_far(K);
  assemble(K);
  set_diagonal_of_slaves(MatrixValues(A), MatrixValues(K));
  assemble(K);
}

void ConstrainedProduct::put_diagonal(Mat K, Vec D) const {
  const MatrixValues values(K);
  const ArrayView diagonal(D);
  for (const EntryRun& run : changed_) diagonal[run.to] = values[0][run.from];
}

void ConstrainedProduct::set_diagonal_of_slaves(const MatrixValues& A, const MatrixValues& K) const {
  double largest = 0.0;
  for (const EntryRun& run : of_slaves_) largest = std::max(largest, std::abs(A[0][run.from]));
  if (!(largest > 0.0)) largest = 1.0;
  for (const EntryRun& run : of_slaves_) {
    const double size = std::abs(A[0][run.from]);
    K[0][run.to] = size > 0.0 ? size : largest;
  }
}

}  // namespace pliant
