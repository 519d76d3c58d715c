#include "solver/linear.hpp"

#include <dmumps_c.h>

namespace pliant {
namespace {

/// Beyond this many unknowns the fill of a factorization costs more time and memory (about 1.6 GB here) than the
/// iterations of CG + GAMG; measured up to 84,000, where it was still ahead.
constexpr PetscInt max_unknowns_of_factorization = 150000;

/// An option the user has not given.
void set_default_option(const char* name, const char* value) {
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, name, &given));
  if (!given) check(PetscOptionsSetValue(nullptr, name, value));
}

bool factorizes_with_mumps(KSP ksp, Mat* factor) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  PetscBool is_cholesky = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &is_cholesky));
  if (!is_cholesky) return false;
  MatSolverType type = nullptr;
  check(PCFactorGetMatSolverType(pc, &type));
  if (type == nullptr || std::string(type) != MATSOLVERMUMPS) return false;
  check(PCFactorSetUpMatSolverType(pc));
  check(PCFactorGetMatrix(pc, factor));
  return *factor != nullptr;
}

}  // namespace

LinearKind automatic_linear_kind(PetscInt num_unknowns) {
  return num_unknowns <= max_unknowns_of_factorization ? LinearKind::cholesky : LinearKind::amg;
}

std::string describe(LinearKind kind) {
  return kind == LinearKind::cholesky
             ? "conjugate gradients preconditioned by a MUMPS LDL^T factorization that is kept while it pays"
             : "conjugate gradients with algebraic multigrid (GAMG)";
}

void configure_linear_solver(KSP ksp, Mat K, LinearKind kind) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(KSPSetOperators(ksp, K, K));
  check(KSPSetType(ksp, KSPCG));
  check(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  check(KSPSetTolerances(ksp, 1e-5, PETSC_DEFAULT, PETSC_DEFAULT, 500));
  if (kind == LinearKind::cholesky) {
    check(PCSetType(pc, PCCHOLESKY));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  } else {
    check(PCSetType(pc, PCGAMG));
    check(PCGAMGSetReuseInterpolation(pc, PETSC_TRUE));
    set_default_option("-mg_levels_ksp_type", "chebyshev");
    set_default_option("-mg_levels_pc_type", "jacobi");
    set_default_option("-pc_gamg_threshold", "0.01");
  }
  check(KSPSetFromOptions(ksp));
  Mat factor = nullptr;
  if (factorizes_with_mumps(ksp, &factor)) {
    check(MatMumpsSetIcntl(factor, 7, 4));    // ordering: PORD; Debian's MUMPS has neither METIS nor SCOTCH
    check(MatMumpsSetIcntl(factor, 13, 1));   // no ScaLAPACK at the root: its pivots would be missing from the inertia
    check(MatMumpsSetIcntl(factor, 14, 40));  // per cent of workspace beyond the estimate
  }
}

std::string mumps_version() {
  return MUMPS_VERSION;
}

PetscInt negative_pivots(KSP ksp) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(ksp, &factor)) return 0;
  PetscInt negative = 0;
  check(MatGetInertia(factor, &negative, nullptr, nullptr));
  return negative;
}

}  // namespace pliant
