/// The kinds of linear solvers, and the automatic choice among them.
#pragma once

#include "energy/term.hpp"

#include <string>

#include <petscsys.h>

namespace pliant {

enum class LinearKind {
  cholesky,    ///< factorization: LDL^T, or LU if the matrix is unsymmetric in more than a few rows
  amg,         ///< algebraic multigrid
  p_multigrid  ///< for quadratic elements: linear elements as the coarse level, solved by one of the others
};

/// The kind chosen for `auto`, for elements of that order.
LinearKind automatic_linear_kind(PetscInt num_unknowns, int order);

/// "conjugate gradients preconditioned by a MUMPS LDL^T factorization ..."
std::string describe(LinearKind kind, Symmetry symmetry);

}  // namespace pliant
