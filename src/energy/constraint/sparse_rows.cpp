#include "energy/constraint/sparse_rows.hpp"

namespace pliant {

Handle<Mat> make_sparse_matrix(MPI_Comm comm, const SparseRows& rows) {
  std::vector<PetscInt> offsets{0}, columns;
  std::vector<double> values;
  for (const auto& row : rows) {
    for (const auto& [column, value] : row) {
      columns.push_back(column);
      values.push_back(value);
    }
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  const auto num_owned = static_cast<PetscInt>(rows.size());
  Handle<Mat> matrix;
  check(MatCreate(comm, matrix.out()));
  check(MatSetSizes(matrix.get(), num_owned, num_owned, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix.get(), MATMPIAIJ));
  check(MatSetBlockSize(matrix.get(), 3));
  check(MatMPIAIJSetPreallocationCSR(matrix.get(), offsets.data(), columns.data(), values.data()));
  return matrix;
}

}  // namespace pliant
