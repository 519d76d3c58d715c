/// Linear solvers for Newton's method: Krylov methods preconditioned by factorizations (MUMPS) or multigrid.
#pragma once

#include "base/several.hpp"
#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"
#include "solver/linear_kind.hpp"
#include "solver/single_factorization.hpp"

#include <optional>
#include <span>
#include <string>

namespace pliant {

/// Sets up `ksp` for the matrix K (with its near-null space, for multigrid) and the given method: conjugate gradients
/// if K is symmetric and not indefinite, GMRES otherwise. p-multigrid needs the coarse space and a symmetric K;
/// without them it becomes algebraic multigrid. PETSc options (-ksp_..., -pc_..., -mat_mumps_...)
/// override. Collective.
void configure_linear_solver(KSP ksp, Mat K, LinearKind kind, Symmetry symmetry,
                             const Coarsening* coarsening = nullptr);

/// Sets the Krylov method for matrices of that symmetry, conjugate gradients or GMRES, and leaves the preconditioner
/// unchanged. Collective.
void set_krylov_method(KSP ksp, Symmetry symmetry);

/// Sets up the preconditioner (factorizes) for the current K, and keeps it for all further solves. A factorization that
/// runs out of workspace is repeated with more; one that runs out of memory is permanently replaced by multigrid,
/// unless the user asked for the factorization or K is indefinite. Solve only if the outcome is `sound`. Collective.
SetUp set_up_preconditioner(PC pc, Mat K, Indefinite indefinite = Indefinite::verified);

/// Makes the next set-up the same as the first one of a new solver: nothing remains of aggregates that multigrid has
/// made for another matrix, nor of what `refine_factorization` has done. Collective.
void forget_set_ups(PC pc);

/// Makes all further set-ups more accurate: of the whole matrix instead of its symmetric part, in double precision,
/// then with another ordering. Returns false if the preconditioner is not one of Pliant's factorizations, or nothing
/// better is available. Collective.
bool refine_factorization(PC pc);

/// Whether the factorization is that of the symmetric part of a nearly symmetric matrix.
bool is_of_symmetric_part(PC pc);

/// Whether a set-up uses the near-null space of the matrix.
bool uses_near_null_space(PC pc);

/// Whether multigrid takes the place of a factorization until `refine_factorization`.
bool may_become_factorization(PC pc);

/// Whether multigrid has replaced the factorization.
bool uses_multigrid_instead(PC pc);

/// x = the preconditioner times b, for the own entries of several vectors at once; false if it is one of PETSc's.
/// Collective.
bool apply_to_several(PC pc, std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x);

/// Cost of a set-up of the preconditioner, in iterations of the Krylov method with it: an estimate that depends only on
/// the matrix, not on measured times.
double cost_of_set_up(PC pc);

/// Whether the preconditioner is Pliant's own, not one that was chosen by PETSc's options.
bool is_own_preconditioner(PC pc);

/// Whether the preconditioner depends only on the matrix of its last set-up, as a factorization does.
bool is_factorization(PC pc);

/// Version of MUMPS, the library that factorizes, e.g. "5.5.1".
std::string mumps_version();

/// Number of negative pivots of the current factorization, if it is LDL^T and reports them; those of LU have no
/// meaning. Collective.
std::optional<PetscInt> negative_pivots(PC pc);

}  // namespace pliant
