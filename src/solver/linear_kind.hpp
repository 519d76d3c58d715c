/// The kinds of linear solvers, and which one is chosen.
#pragma once

#include "energy/term.hpp"

#include <string>

#include <petscsys.h>

namespace pliant {

enum class LinearKind {
  cholesky,    ///< factorization: LDL^T, or LU where the matrix is unsymmetric
  amg,         ///< algebraic multigrid
  p_multigrid  ///< of quadratic elements: to their linear functions, and from there by one of the others
};

/// What is chosen when the user says `auto`, for elements of that order.
LinearKind automatic_linear_kind(PetscInt num_unknowns, int order);

/// "conjugate gradients preconditioned by a MUMPS LDL^T factorization ..."
std::string describe(LinearKind kind, Symmetry symmetry = Symmetry::symmetric);

}  // namespace pliant
