/// Sparse square matrices from rows of coefficients.
#pragma once

#include "petsc/handle.hpp"

#include <map>
#include <vector>

namespace pliant {

/// Coefficients by global column, one map per owned row.
using SparseRows = std::vector<std::map<PetscInt, double>>;

/// The matrix of the ranks' rows, of type MATMPIAIJ, with as many columns as rows on each rank and blocks of three.
/// Collective.
Handle<Mat> make_sparse_matrix(MPI_Comm comm, const SparseRows& rows);

}  // namespace pliant
