/// The kinds of linear solvers, and the automatic choice among them.
#pragma once

#include "energy/term.hpp"

#include <string>

#include <petscsys.h>

namespace pliant {

enum class LinearKind {
  cholesky,    ///< factorization: LDL^T, or LU if the matrix is unsymmetric in more than a few rows
  amg,         ///< algebraic multigrid
  adaptive,    ///< algebraic multigrid while it takes few iterations, else the factorization
  p_multigrid  ///< for quadratic elements: linear elements as the coarse level, solved by one of the others
};

/// The kind chosen for `auto`, for elements of that order. `may_adapt`: whether multigrid may solve although it does
/// not count negative eigenvalues.
LinearKind automatic_linear_kind(PetscInt num_unknowns, int order, bool may_adapt);

/// "conjugate gradients preconditioned by a MUMPS LDL^T factorization ..."
std::string describe(LinearKind kind, Symmetry symmetry);

}  // namespace pliant
