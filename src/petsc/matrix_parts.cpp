#include "petsc/matrix_parts.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <cassert>
#include <ranges>

namespace pliant {

MatrixValues::MatrixValues(Mat matrix) {
  check(MatMPIAIJGetSeqAIJ(matrix, &parts_[0], &parts_[1], nullptr));
  for (std::size_t p = 0; p < 2; ++p) check(MatSeqAIJGetArray(parts_[p], &values_[p]));
}

MatrixValues::~MatrixValues() {
  for (std::size_t p = 0; p < 2; ++p) (void)MatSeqAIJRestoreArray(parts_[p], &values_[p]);
}

MatrixRows::MatrixRows(Mat matrix, std::size_t part) {
  Mat parts[2] = {nullptr, nullptr};
  const PetscInt* columns_of_others = nullptr;
  check(MatMPIAIJGetSeqAIJ(matrix, &parts[0], &parts[1], &columns_of_others));
  part_ = parts[part];
  if (part == 0) check(MatGetOwnershipRangeColumn(matrix, &first_, nullptr));
  if (part == 1) numbers_ = columns_of_others;
  PetscBool is_done = PETSC_FALSE;
  check(MatGetRowIJ(part_, 0, PETSC_FALSE, PETSC_FALSE, &num_rows_, &offsets_, &columns_, &is_done));
}

MatrixRows::~MatrixRows() {
  PetscBool is_done = PETSC_FALSE;
  (void)MatRestoreRowIJ(part_, 0, PETSC_FALSE, PETSC_FALSE, &num_rows_, &offsets_, &columns_, &is_done);
}

PetscInt MatrixRows::entry(PetscInt row, PetscInt in_matrix) const {
  const auto entries = std::views::iota(begin(row), end(row));
  const auto found = std::ranges::lower_bound(entries, in_matrix, {}, [&](PetscInt k) { return column(k); });
  assert(found != entries.end() && column(*found) == in_matrix);
  return *found;
}

void get_diagonal(Mat A, Vec D) {
  const MatrixRows rows(A, 0);
  const MatrixValues values(A);
  const ArrayView diagonal(D);
  PetscInt first = 0;
  check(MatGetOwnershipRange(A, &first, nullptr));
  // In the rows of a node, which have the same columns, it is one place further in each.
  PetscInt next = 0;
  for (PetscInt row = 0; row < rows.size(); ++row) {
    PetscInt k = rows.begin(row) + next;
    if (k >= rows.end(row) || rows.column(k) != first + row) k = rows.entry(row, first + row);
    diagonal[row] = values[0][k];
    next = k - rows.begin(row) + 1;
  }
}

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

Handle<Mat> make_zero_matrix(Mat like, const std::vector<PetscInt>& offsets, const std::vector<PetscInt>& columns) {
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

}  // namespace pliant
