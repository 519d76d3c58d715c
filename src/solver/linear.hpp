/// How the linear systems of Newton's method are solved.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"
#include "solver/linear_kind.hpp"
#include "solver/single_factorization.hpp"

#include <optional>
#include <string>

namespace pliant {

/// Sets up `ksp` for the matrix K (with its near-null space, for multigrid) and the given method: conjugate gradients
/// where K is symmetric and not indefinite, else GMRES. p-multigrid needs the
/// coarse space (it is copied from) and a symmetric K; without, it is algebraic multigrid. PETSc options (-ksp_...,
/// -pc_..., -mat_mumps_...) override. Collective.
void configure_linear_solver(KSP ksp, Mat K, LinearKind kind, Symmetry symmetry,
                             const Coarsening* coarsening = nullptr);

/// Makes the Krylov method one for matrices of that kind: conjugate gradients or GMRES, with the preconditioner as it
/// is. Collective.
void set_krylov_method(KSP ksp, Symmetry symmetry);

/// Sets up the preconditioner (factorizes) for the present K, and keeps it for all further solves; a factorization that
/// runs out of workspace is repeated with more. One that runs out of memory gives way to multigrid, for good, unless
/// the user has asked for that factorization or K is indefinite. Unless the outcome is sound, solve nothing.
/// Collective.
SetUp set_up_preconditioner(PC pc, Mat K);

/// Makes the next set-ups more exact, for good: in double precision, then with another ordering. False if the
/// preconditioner is no factorization of ours, or there is nothing better. Collective.
bool refine_factorization(PC pc);

/// Whether multigrid has taken the place of the factorization.
bool uses_multigrid_instead(PC pc);

/// What a set-up of the preconditioner costs, in iterations of the Krylov method with it: an estimate that depends on
/// the matrix alone, not on the clock.
double cost_of_set_up(PC pc);

/// Whether all that the preconditioner applies comes from the matrix of its set-up: a factorization.
bool is_factorization(PC pc);

/// Of the library that factorizes, e.g. "5.5.1".
std::string mumps_version();

/// Number of negative pivots of the current factorization, if it is LDL^T and tells; those of LU mean nothing.
/// Collective.
std::optional<PetscInt> negative_pivots(PC pc);

}  // namespace pliant
