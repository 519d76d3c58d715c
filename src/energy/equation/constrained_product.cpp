#include "energy/equation/constrained_product.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace pliant {
namespace {

/// The values of the two parts of a matrix (PETSc's diagonal and off-diagonal parts), for the time of the object.
class Values {
 public:
  explicit Values(Mat matrix) {
    check(MatMPIAIJGetSeqAIJ(matrix, &parts_[0], &parts_[1], nullptr));
    for (std::size_t p = 0; p < 2; ++p) check(MatSeqAIJGetArray(parts_[p], &values_[p]));
  }
  ~Values() {
    for (std::size_t p = 0; p < 2; ++p) (void)MatSeqAIJRestoreArray(parts_[p], &values_[p]);
  }
  Values(const Values&) = delete;
  Values& operator=(const Values&) = delete;
  double* operator[](std::size_t part) const { return values_[part]; }

 private:
  std::array<Mat, 2> parts_{};
  std::array<double*, 2> values_{};
};

}  // namespace

/// The pattern of one part of a matrix: global columns of each row, ascending.
class ConstrainedProduct::Rows {
 public:
  Rows(Mat matrix, std::size_t part) {
    Mat parts[2] = {nullptr, nullptr};
    const PetscInt* columns_of_others = nullptr;
    check(MatMPIAIJGetSeqAIJ(matrix, &parts[0], &parts[1], &columns_of_others));
    part_ = parts[part];
    if (part == 0) check(MatGetOwnershipRangeColumn(matrix, &first_, nullptr));
    if (part == 1) numbers_ = columns_of_others;
    PetscBool is_done = PETSC_FALSE;
    check(MatGetRowIJ(part_, 0, PETSC_FALSE, PETSC_FALSE, &num_rows_, &offsets_, &columns_, &is_done));
  }
  ~Rows() {
    PetscBool is_done = PETSC_FALSE;
    (void)MatRestoreRowIJ(part_, 0, PETSC_FALSE, PETSC_FALSE, &num_rows_, &offsets_, &columns_, &is_done);
  }
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;

  PetscInt size() const { return num_rows_; }
  PetscInt begin(PetscInt row) const { return offsets_[row]; }
  PetscInt end(PetscInt row) const { return offsets_[row + 1]; }
  PetscInt local_column(PetscInt entry) const { return columns_[entry]; }
  PetscInt column(PetscInt entry) const {
    return numbers_ != nullptr ? numbers_[columns_[entry]] : first_ + columns_[entry];
  }

  /// Runs of the wanted entries, which are among those of `to`.
  template <class Wanted>
  std::vector<Run> runs(const Rows& to, const Wanted& wanted) const {
    std::vector<Run> result;
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

namespace {

/// A flag of each column of both parts of A, from those of the rows.
std::array<std::vector<char>, 2> flags_of_columns(Mat A, const std::vector<char>& of_rows) {
  Mat parts[2] = {nullptr, nullptr};
  const PetscInt* numbers = nullptr;
  check(MatMPIAIJGetSeqAIJ(A, &parts[0], &parts[1], &numbers));
  PetscInt num_others = 0;
  check(MatGetSize(parts[1], nullptr, &num_others));
  Handle<Vec> flags, of_others;
  check(MatCreateVecs(A, flags.out(), nullptr));
  {
    const ArrayView entries(flags.get());
    std::ranges::copy(of_rows, entries.span().begin());
  }
  check(VecCreateSeq(PETSC_COMM_SELF, num_others, of_others.out()));
  Handle<IS> wanted;
  check(ISCreateGeneral(PETSC_COMM_SELF, num_others, numbers, PETSC_COPY_VALUES, wanted.out()));
  Handle<VecScatter> scatter;
  check(VecScatterCreate(flags.get(), wanted.get(), of_others.get(), nullptr, scatter.out()));
  check(VecScatterBegin(scatter.get(), flags.get(), of_others.get(), INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterEnd(scatter.get(), flags.get(), of_others.get(), INSERT_VALUES, SCATTER_FORWARD));
  std::array<std::vector<char>, 2> result{of_rows, {}};
  const ConstArrayView entries(of_others.get());
  for (const double flag : entries.span()) result[1].push_back(flag != 0.0 ? 1 : 0);
  return result;
}

/// A zero matrix with the layout of `like` and these global columns in each row.
Handle<Mat> make_zero(Mat like, const std::vector<PetscInt>& offsets, const std::vector<PetscInt>& columns) {
  PetscInt num_rows = 0, num_columns = 0;
  check(MatGetLocalSize(like, &num_rows, &num_columns));
  Handle<Mat> result;
  check(MatCreate(PetscObjectComm(reinterpret_cast<PetscObject>(like)), result.out()));
  check(MatSetSizes(result.get(), num_rows, num_columns, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(result.get(), MATMPIAIJ));
  check(MatSetBlockSizesFromMats(result.get(), like, like));
  const std::vector<double> values(columns.size(), 0.0);
  check(MatMPIAIJSetPreallocationCSR(result.get(), offsets.data(), columns.data(), values.data()));
  return result;
}

}  // namespace

ConstrainedProduct::ConstrainedProduct(Mat A, Mat W, Mat J, const std::vector<char>& is_tied) : W_(W), J_(J) {
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
    const Rows own(A, 0), others(A, 1), own_product(product_.get(), 0), others_product(product_.get(), 1);
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
  pattern_ = make_zero(J, offsets, columns);
  for (std::size_t p = 0; p < 2; ++p) {
    const Rows of_A(A, p), near(near_.get(), p), of_product(product_.get(), p), of_K(pattern_.get(), p);
    const auto is_near = [&](PetscInt row, PetscInt k) {
      return is_tied_row_[static_cast<std::size_t>(row)] ||
             is_tied_column_[p][static_cast<std::size_t>(of_A.local_column(k))];
    };
    near_from_A_[p] = of_A.runs(near, is_near);
    K_from_A_[p] = of_A.runs(of_K, [&](PetscInt row, PetscInt k) { return !is_near(row, k); });
    K_from_product_[p] = of_product.runs(of_K, [](PetscInt, PetscInt) { return true; });
  }
}

void ConstrainedProduct::make_near(Mat A) {
  std::vector<PetscInt> offsets{0}, columns;
  const Rows own(A, 0), others(A, 1);
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
  near_ = make_zero(A, offsets, columns);
}

void ConstrainedProduct::multiply(MatReuse reuse) {
  Mat product = product_.get(), with_J = near_times_J_.get();
  if (W_ == J_) {
    check(MatPtAP(near_.get(), J_, reuse, PETSC_DEFAULT, reuse == MAT_REUSE_MATRIX ? &product : product_.out()));
    return;
  }
  check(MatMatMult(near_.get(), J_, reuse, PETSC_DEFAULT, reuse == MAT_REUSE_MATRIX ? &with_J : near_times_J_.out()));
  check(MatTransposeMatMult(W_, near_times_J_.get(), reuse, PETSC_DEFAULT,
                            reuse == MAT_REUSE_MATRIX ? &product : product_.out()));
}

Handle<Mat> ConstrainedProduct::make() const {
  Handle<Mat> K;
  check(MatDuplicate(pattern_.get(), MAT_DO_NOT_COPY_VALUES, K.out()));
  return K;
}

void ConstrainedProduct::set(Mat A, Mat K) {
  {
    const Values from(A), to(near_.get());
    for (std::size_t p = 0; p < 2; ++p) {
      for (const Run& run : near_from_A_[p]) std::copy_n(from[p] + run.from, run.count, to[p] + run.to);
    }
  }
  check(MatAssemblyBegin(near_.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(near_.get(), MAT_FINAL_ASSEMBLY));
  multiply(MAT_REUSE_MATRIX);
  {
    const Values of_A(A), of_product(product_.get()), to(K);
    for (std::size_t p = 0; p < 2; ++p) {
      for (const Run& run : K_from_product_[p]) std::fill_n(to[p] + run.to, run.count, 0.0);
      for (const Run& run : K_from_A_[p]) std::copy_n(of_A[p] + run.from, run.count, to[p] + run.to);
      for (const Run& run : K_from_product_[p]) {
        for (PetscInt k = 0; k < run.count; ++k) to[p][run.to + k] += of_product[p][run.from + k];
      }
    }
  }
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

}  // namespace pliant
