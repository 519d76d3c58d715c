#include "energy/constraint/beside_identity.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// The blocks of a matrix (PETSc's diagonal and off-diagonal parts): the columns of this rank, and those of the others.
struct Parts {
  explicit Parts(Mat matrix) { check(MatMPIAIJGetSeqAIJ(matrix, &parts[0], &parts[1], &columns)); }
  Mat parts[2] = {nullptr, nullptr};
  const PetscInt* columns = nullptr;  // of the second part, over all ranks
};

}  // namespace

BesideIdentity::BesideIdentity(Mat A, Vec unknowns) : A_(A) {
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(A));
  int size = 1;
  check_mpi(MPI_Comm_size(comm, &size));
  const PetscInt *rows = nullptr, *places = nullptr;
  check(MatGetOwnershipRanges(A, &rows));
  check(VecGetOwnershipRanges(unknowns, &places));
  first_row_.assign(rows, rows + size + 1);
  first_unknown_.assign(places, places + size + 1);
  if (first_row_.back() == first_unknown_.back()) {
    check(PetscObjectReference(reinterpret_cast<PetscObject>(A)));
    whole_ = Handle<Mat>(A);
    return;
  }
  PetscInt first = 0, last = 0, num_unknowns = 0;
  check(MatGetOwnershipRange(A, &first, &last));
  check(VecGetLocalSize(unknowns, &num_unknowns));
  std::vector<PetscInt> offsets{0}, columns;
  std::vector<double> values;
  for (PetscInt row = first; row < last; ++row) {
    PetscInt n = 0;
    const PetscInt* of_row = nullptr;
    const double* entries = nullptr;
    check(MatGetRow(A, row, &n, &of_row, &entries));
    for (PetscInt k = 0; k < n; ++k) columns.push_back(place(of_row[k]));
    values.insert(values.end(), entries, entries + n);
    check(MatRestoreRow(A, row, &n, &of_row, &entries));
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  const PetscInt start = place(first);
  for (PetscInt i = last - first; i < num_unknowns; ++i) {
    columns.push_back(start + i);
    values.push_back(1.0);
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  check(MatCreate(comm, whole_.out()));
  check(MatSetSizes(whole_.get(), num_unknowns, num_unknowns, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(whole_.get(), MATMPIAIJ));
  check(MatMPIAIJSetPreallocationCSR(whole_.get(), offsets.data(), columns.data(), values.data()));
}

PetscInt BesideIdentity::place(PetscInt row) const {
  const auto owner = std::upper_bound(first_row_.begin(), first_row_.end(), row) - first_row_.begin() - 1;
  return row - first_row_[static_cast<std::size_t>(owner)] + first_unknown_[static_cast<std::size_t>(owner)];
}

// Both parts hold their entries row by row in ascending columns, an order that the new numbers preserve.
void BesideIdentity::update() {
  if (whole_.get() == A_) return;
  const Parts from(A_), to(whole_.get());
  for (int k = 0; k < 2; ++k) {
    const double* entries = nullptr;
    double* copies = nullptr;
    PetscInt rows = 0;
    const PetscInt *offsets = nullptr, *columns = nullptr;
    PetscBool is_done = PETSC_FALSE;
    check(MatGetRowIJ(from.parts[k], 0, PETSC_FALSE, PETSC_FALSE, &rows, &offsets, &columns, &is_done));
    check(MatSeqAIJGetArrayRead(from.parts[k], &entries));
    check(MatSeqAIJGetArray(to.parts[k], &copies));
    std::copy_n(entries, offsets[rows], copies);
    check(MatSeqAIJRestoreArray(to.parts[k], &copies));
    check(MatSeqAIJRestoreArrayRead(from.parts[k], &entries));
    check(MatRestoreRowIJ(from.parts[k], 0, PETSC_FALSE, PETSC_FALSE, &rows, &offsets, &columns, &is_done));
  }
  check(MatAssemblyBegin(whole_.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(whole_.get(), MAT_FINAL_ASSEMBLY));
}

}  // namespace pliant
