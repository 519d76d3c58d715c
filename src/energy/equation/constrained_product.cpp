#include "energy/equation/constrained_product.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pliant {
ConstrainedProduct::ConstrainedProduct(Mat A, Mat W, Mat J, const std::vector<char>& is_tied,
                                       const std::vector<char>& is_slave)
    : W_(W), J_(J) {
  PetscInt num_rows = 0;
  check(MatGetLocalSize(A, &num_rows, nullptr));
  is_tied_row_.assign(is_tied.begin(), is_tied.end());
  is_tied_row_.resize(static_cast<std::size_t>(num_rows), 0);
  is_tied_column_ = flags_of_columns(A, is_tied_row_);
  make_near(A);
  multiply(MAT_INITIAL_MATRIX);
  // Rows of K: the entries that are copied, and those of the product.
  std::vector<PetscInt> offsets{0}, columns, row_of_K;
  {
    const MatrixRows own(A, 0), others(A, 1), own_product(product_.get(), 0), others_product(product_.get(), 1);
    const std::array of_A{&own, &others}, of_product{&own_product, &others_product};
    for (PetscInt row = 0; row < num_rows; ++row) {
      row_of_K.clear();
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
  }
  pattern_ = make_zero_matrix(J, offsets, columns);
  find_diagonal(is_slave);
  for (std::size_t p = 0; p < 2; ++p) {
    const MatrixRows of_A(A, p), near(near_.get(), p), of_product(product_.get(), p), of_K(pattern_.get(), p);
    const auto is_near = [&](PetscInt row, PetscInt k) {
      return is_tied_row_[static_cast<std::size_t>(row)] ||
             is_tied_column_[p][static_cast<std::size_t>(of_A.local_column(k))];
    };
    near_from_A_[p] = of_A.runs(near, is_near);
    K_from_A_[p] = of_A.runs(of_K, [&](PetscInt row, PetscInt k) { return !is_near(row, k); });
    K_from_product_[p] = of_product.runs(of_K, [](PetscInt, PetscInt) { return true; });
  }
}

void ConstrainedProduct::find_diagonal(const std::vector<char>& is_slave) {
  const MatrixRows own(pattern_.get(), 0);
  for (PetscInt row = 0; row < own.size(); ++row) {
    for (PetscInt k = own.begin(row); k < own.end(row); ++k) {
      if (own.local_column(k) != row) continue;
      const bool is_of_slave = static_cast<std::size_t>(row) < is_slave.size() && is_slave[row];
      (is_of_slave ? of_slaves_ : of_others_).push_back(k);
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
  Mat product = product_.get(), with_J = near_times_J_.get();
  if (W_ == J_) {
    check(MatPtAP(near_.get(), J_, reuse, PETSC_DEFAULT, reuse == MAT_REUSE_MATRIX ? &product : product_.out()));
    return;
  }
  // MatTransposeMatMult of these matrices would put its entries one by one.
  Mat transposed = W_transposed_.get();
  check(MatTranspose(W_, reuse, reuse == MAT_REUSE_MATRIX ? &transposed : W_transposed_.out()));
  check(MatMatMult(near_.get(), J_, reuse, PETSC_DEFAULT, reuse == MAT_REUSE_MATRIX ? &with_J : near_times_J_.out()));
  check(MatMatMult(W_transposed_.get(), near_times_J_.get(), reuse, PETSC_DEFAULT,
                   reuse == MAT_REUSE_MATRIX ? &product : product_.out()));
}

Handle<Mat> ConstrainedProduct::make() const {
  Handle<Mat> K;
  check(MatDuplicate(pattern_.get(), MAT_DO_NOT_COPY_VALUES, K.out()));
  return K;
}

void ConstrainedProduct::set(Mat A, Mat K) {
  {
    const MatrixValues from(A), to(near_.get());
    for (std::size_t p = 0; p < 2; ++p) {
      for (const EntryRun& run : near_from_A_[p]) std::copy_n(from[p] + run.from, run.count, to[p] + run.to);
    }
  }
  check(MatAssemblyBegin(near_.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(near_.get(), MAT_FINAL_ASSEMBLY));
  multiply(MAT_REUSE_MATRIX);
  {
    const MatrixValues of_A(A), of_product(product_.get()), to(K);
    for (std::size_t p = 0; p < 2; ++p) {
      for (const EntryRun& run : K_from_product_[p]) std::fill_n(to[p] + run.to, run.count, 0.0);
      for (const EntryRun& run : K_from_A_[p]) std::copy_n(of_A[p] + run.from, run.count, to[p] + run.to);
      for (const EntryRun& run : K_from_product_[p]) {
        for (PetscInt k = 0; k < run.count; ++k) to[p][run.to + k] += of_product[p][run.from + k];
      }
    }
    set_diagonal_of_slaves(to);
  }
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

void ConstrainedProduct::set_diagonal_of_slaves(const MatrixValues& K) const {
  double sums[2] = {0.0, static_cast<double>(of_others_.size())};
  for (const PetscInt entry : of_others_) sums[0] += std::abs(K[0][entry]);
  sum_in_place(PetscObjectComm(reinterpret_cast<PetscObject>(pattern_.get())), sums);
  const double mean = sums[0] > 0.0 ? sums[0] / sums[1] : 1.0;
  for (const PetscInt entry : of_slaves_) K[0][entry] = mean;
}

}  // namespace pliant
