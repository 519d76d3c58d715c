/// How the linear systems of Newton's method are solved.
#pragma once

#include "petsc/handle.hpp"

#include <string>

namespace pliant {

enum class LinearKind { cholesky, amg };

/// What is chosen when the user says `auto`.
LinearKind automatic_linear_kind(PetscInt num_unknowns);

/// "MUMPS LDL^T" ...
std::string describe(LinearKind kind);

/// Sets up `ksp` for the symmetric matrix K (with its near-null space, for multigrid) and the given method; PETSc
/// options (-ksp_..., -pc_..., -mat_mumps_...) override. Collective.
void configure_linear_solver(KSP ksp, Mat K, LinearKind kind);

/// Of the library that factorizes, e.g. "5.5.1".
std::string mumps_version();

/// Number of negative pivots of the current factorization, if the solver factorizes and tells; else 0. Collective.
PetscInt negative_pivots(KSP ksp);

}  // namespace pliant
