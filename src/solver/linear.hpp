/// How the linear systems of Newton's method are solved.
#pragma once

#include "fem/layout.hpp"
#include "petsc/handle.hpp"

#include <string>

namespace pliant {

enum class LinearKind { cholesky, amg };

/// What is chosen when the user says `auto`.
LinearKind automatic_linear_kind(const NodeLayout& layout);

/// "MUMPS LDL^T" ...
std::string describe(LinearKind kind);

/// Sets up `ksp` for the symmetric matrix K with the given method; PETSc options (-ksp_..., -pc_..., -mat_mumps_...)
/// override. `prescribed`: one flag per local entry, left out of the near-null space. Collective.
void configure_linear_solver(KSP ksp, Mat K, LinearKind kind, const NodeLayout& layout,
                             const std::vector<char>& prescribed);

/// Of the library that factorizes, e.g. "5.5.1".
std::string mumps_version();

/// Number of negative pivots of the current factorization, if the solver factorizes and tells; else 0. Collective.
PetscInt negative_pivots(KSP ksp);

}  // namespace pliant
