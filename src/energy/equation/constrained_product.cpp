#include "energy/equation/constrained_product.hpp"

#include "petsc/collective.hpp"

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
  W_rows_ = W_;
  multiply(MAT_INITIAL_MATRIX);
  make_pattern(A);
  of_whole_product_ = K_from_product();
  if (!dense.empty()) {
    make_sparse_rows(dense);
    multiply(MAT_INITIAL_MATRIX);
    const auto is_zero = flags_of_columns(near_times_J_.get(), is_slave_row_);
    for (RowsOfColumns& rows : dense) {
      dense_.emplace_back(std::move(rows), W_, near_times_J_.get(), pattern_.get(), is_zero);
    }
  }
  K_from_product_ = K_from_product();
  find_runs_from(A);
  find_diagonal();
}

// Rows of K: the entries that are copied, those of the product, and the diagonal.
void ConstrainedProduct::make_pattern(Mat A) {
  const auto is_slave_column = flags_of_columns(product_.get(), is_slave_row_);
  std::vector<PetscInt> offsets{0}, columns, row_of_K;
  PetscInt first = 0;
  check(MatGetOwnershipRange(A, &first, nullptr));
  const MatrixRows own(A, 0), others(A, 1), own_product(product_.get(), 0), others_product(product_.get(), 1);
  const std::array of_A{&own, &others}, of_product{&own_product, &others_product};
  for (PetscInt row = 0; row < own.size(); ++row) {
    const auto i = static_cast<std::size_t>(row);
    row_of_K.assign(1, first + row);
    for (std::size_t p = 0; p < 2; ++p) {
      for (PetscInt k = of_A[p]->begin(row); k < of_A[p]->end(row); ++k) {
        const auto column = static_cast<std::size_t>(of_A[p]->local_column(k));
        if (!is_tied_row_[i] && !is_tied_column_[p][column]) row_of_K.push_back(of_A[p]->column(k));
      }
      for (PetscInt k = of_product[p]->begin(row); k < of_product[p]->end(row); ++k) {
        const auto column = static_cast<std::size_t>(of_product[p]->local_column(k));
        if (!is_slave_row_[i] && !is_slave_column[p][column]) row_of_K.push_back(of_product[p]->column(k));
      }
    }
    std::ranges::sort(row_of_K);
    row_of_K.erase(std::unique(row_of_K.begin(), row_of_K.end()), row_of_K.end());
    columns.insert(columns.end(), row_of_K.begin(), row_of_K.end());
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  pattern_ = make_zero_matrix(J_, offsets, columns);
}

void ConstrainedProduct::make_sparse_rows(const std::vector<RowsOfColumns>& dense) {
  std::vector<char> is_dense(is_tied_row_.size(), 0);
  for (const RowsOfColumns& group : dense) {
    for (const PetscInt row : group.rows) is_dense[static_cast<std::size_t>(row)] = 1;
  }
  const auto is_wanted = [&](PetscInt row, PetscInt) { return !is_dense[static_cast<std::size_t>(row)]; };
  std::vector<PetscInt> offsets{0}, columns;
  {
    const MatrixRows own(W_, 0), others(W_, 1);
    for (PetscInt row = 0; row < own.size(); ++row) {
      const auto first = static_cast<std::ptrdiff_t>(columns.size());
      for (const MatrixRows* part : {&own, &others}) {
        for (PetscInt k = part->begin(row); k < part->end(row); ++k) {
          if (is_wanted(row, k)) columns.push_back(part->column(k));
        }
      }
      std::sort(columns.begin() + first, columns.end());
      offsets.push_back(static_cast<PetscInt>(columns.size()));
    }
  }
  sparse_rows_ = make_zero_matrix(W_, offsets, columns);
  for (std::size_t p = 0; p < 2; ++p) {
    const MatrixRows of_W(W_, p), of_rest(sparse_rows_.get(), p);
    sparse_rows_from_W_[p] = of_W.runs(of_rest, is_wanted);
  }
  W_rows_ = sparse_rows_.get();
}

ConstrainedProduct::Runs ConstrainedProduct::K_from_product() const {
  const auto is_slave_column = flags_of_columns(product_.get(), is_slave_row_);
  Runs runs;
  for (std::size_t p = 0; p < 2; ++p) {
    const MatrixRows of_product(product_.get(), p), of_K(pattern_.get(), p);
    runs[p] = of_product.runs(of_K, [&](PetscInt row, PetscInt k) {
      return !is_slave_row_[static_cast<std::size_t>(row)] &&
             !is_slave_column[p][static_cast<std::size_t>(of_product.local_column(k))];
    });
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

void ConstrainedProduct::find_diagonal() {
  const MatrixRows own(pattern_.get(), 0);
  for (PetscInt row = 0; row < own.size(); ++row) {
    for (PetscInt k = own.begin(row); k < own.end(row); ++k) {
      if (own.local_column(k) != row) continue;
      (is_slave_row_[static_cast<std::size_t>(row)] ? of_slaves_ : of_others_).push_back(k);
    }
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
    check(MatPtAP(near_.get(), J_, reuse, PETSC_DEFAULT, is_there ? &product : product_.out()));
    return;
  }
  // MatTransposeMatMult of these matrices would put its entries one by one.
  check(MatTranspose(W_rows_, reuse, is_there ? &transposed : transposed_.out()));
  check(MatMatMult(near_.get(), J_, reuse, PETSC_DEFAULT, is_there ? &with_J : near_times_J_.out()));
  check(MatMatMult(transposed_.get(), near_times_J_.get(), reuse, PETSC_DEFAULT, is_there ? &product : product_.out()));
}

Handle<Mat> ConstrainedProduct::make() const {
  Handle<Mat> K;
  check(MatDuplicate(pattern_.get(), MAT_DO_NOT_COPY_VALUES, K.out()));
  return K;
}

void ConstrainedProduct::set(Mat A, Mat K) {
  copy(near_from_A_, A, near_.get());
  if (!dense_.empty()) copy(sparse_rows_from_W_, W_, sparse_rows_.get());
  multiply(MAT_REUSE_MATRIX);
  {
    const MatrixValues of_A(A), of_product(product_.get()), to(K);
    for (std::size_t p = 0; p < 2; ++p) {
      for (const EntryRun& run : of_whole_product_[p]) std::fill_n(to[p] + run.to, run.count, 0.0);
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
  set_diagonal_of_slaves(MatrixValues(K));
  assemble(K);
}

void ConstrainedProduct::set_diagonal_of_slaves(const MatrixValues& K) const {
  double sums[2] = {0.0, static_cast<double>(of_others_.size())};
  for (const PetscInt entry : of_others_) sums[0] += std::abs(K[0][entry]);
  sum_in_place(PetscObjectComm(reinterpret_cast<PetscObject>(pattern_.get())), sums);
  const double mean = sums[0] > 0.0 ? sums[0] / sums[1] : 1.0;
  for (const PetscInt entry : of_slaves_) K[0][entry] = mean;
}

}  // namespace pliant
