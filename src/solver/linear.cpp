#include "solver/linear.hpp"

#include <dmumps_c.h>

namespace pliant {
namespace {

/// Beyond this many unknowns the fill of a factorization costs more time and memory (about 1.6 GB here) than the
/// iterations of CG + GAMG; measured up to 84,000, where it was still ahead.
constexpr PetscInt max_unknowns_of_factorization = 150000;
constexpr PetscInt min_unknowns_of_pord = 100;
/// Workspace of MUMPS beyond its estimate, in per cent: where pivoting needs more, it is multiplied by four and tried
/// again.
constexpr PetscInt first_workspace = 40, last_workspace = 10240;
/// Vectors that GMRES keeps before it starts anew. With a factor it needs a few; with multigrid some tens.
constexpr PetscInt gmres_restart = 60;

/// An option the user has not given.
void set_default_option(const char* name, const char* value) {
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, name, &given));
  if (!given) check(PetscOptionsSetValue(nullptr, name, value));
}

/// Whether the preconditioner is a factorization of that type (PCCHOLESKY or PCLU) by MUMPS.
bool factorizes_with_mumps(PC pc, PCType wanted, Mat* factor) {
  PetscBool is_wanted = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), wanted, &is_wanted));
  if (!is_wanted) return false;
  MatSolverType type = nullptr;
  check(PCFactorGetMatSolverType(pc, &type));
  if (type == nullptr || std::string(type) != MATSOLVERMUMPS) return false;
  check(PCFactorSetUpMatSolverType(pc));
  check(PCFactorGetMatrix(pc, factor));
  return *factor != nullptr;
}

bool factorizes_with_mumps(PC pc, Mat* factor) {
  return factorizes_with_mumps(pc, PCCHOLESKY, factor) || factorizes_with_mumps(pc, PCLU, factor);
}

/// `workspace`: per cent beyond MUMPS's estimate.
void control_mumps(PC pc, Mat K, PetscInt workspace) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(pc, &factor)) return;
  // Ordering: PORD, as Debian's MUMPS has neither METIS nor SCOTCH. It ends the process where all unknowns couple with
  // all (a rigid body, a single cell): AMD there.
  PetscInt num_unknowns = 0;
  check(MatGetSize(K, &num_unknowns, nullptr));
  check(MatMumpsSetIcntl(factor, 7, num_unknowns < min_unknowns_of_pord ? 0 : 4));
  check(MatMumpsSetIcntl(factor, 13, 1));  // no ScaLAPACK at the root: its pivots would be missing from the inertia
  check(MatMumpsSetIcntl(factor, 14, workspace));
}

}  // namespace

LinearKind automatic_linear_kind(PetscInt num_unknowns) {
  return num_unknowns <= max_unknowns_of_factorization ? LinearKind::cholesky : LinearKind::amg;
}

std::string describe(LinearKind kind, Symmetry symmetry) {
  const bool is_symmetric = symmetry != Symmetry::unsymmetric;
  const std::string krylov = symmetry == Symmetry::symmetric ? "conjugate gradients" : "GMRES";
  return krylov + (kind == LinearKind::amg ? " with algebraic multigrid (GAMG)"
                   : is_symmetric          ? " preconditioned by a MUMPS LDL^T factorization that is kept while it pays"
                                           : " preconditioned by a MUMPS LU factorization that is kept while it pays");
}

void configure_linear_solver(KSP ksp, Mat K, LinearKind kind, Symmetry symmetry) {
  const bool is_symmetric = symmetry != Symmetry::unsymmetric;
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(KSPSetOperators(ksp, K, K));
  if (symmetry == Symmetry::symmetric) {
    check(KSPSetType(ksp, KSPCG));
  } else {
    check(KSPSetType(ksp, KSPGMRES));
    check(KSPSetPCSide(ksp, PC_RIGHT));  // so that its residual is that of the system
    check(KSPGMRESSetRestart(ksp, gmres_restart));
  }
  check(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  check(KSPSetTolerances(ksp, 1e-5, PETSC_DEFAULT, PETSC_DEFAULT, 500));
  if (kind == LinearKind::cholesky) {
    check(PCSetType(pc, is_symmetric ? PCCHOLESKY : PCLU));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  } else {
    check(PCSetType(pc, PCGAMG));
    check(PCGAMGSetReuseInterpolation(pc, PETSC_TRUE));
    set_default_option("-mg_levels_ksp_type", "chebyshev");
    set_default_option("-mg_levels_pc_type", "jacobi");
    set_default_option("-pc_gamg_threshold", "0.01");
  }
  check(KSPSetFromOptions(ksp));
  control_mumps(pc, K, first_workspace);
}

bool set_up_preconditioner(PC pc, Mat K) {
  check(PCSetReusePreconditioner(pc, PETSC_FALSE));
  check(PCSetOperators(pc, K, K));
  bool is_sound = false, lacks_workspace = true;
  for (PetscInt workspace = first_workspace; lacks_workspace && workspace <= last_workspace;) {
    check(PCSetUp(pc));
    PCFailedReason failure = PC_NOERROR;
    check(PCGetFailedReason(pc, &failure));
    is_sound = failure == PC_NOERROR;
    if (is_sound) break;
    Mat factor = nullptr;
    PetscInt error = 0;
    if (factorizes_with_mumps(pc, &factor)) check(MatMumpsGetInfog(factor, 1, &error));
    lacks_workspace = error == -8 || error == -9;
    if (lacks_workspace) workspace *= 4;
    // PETSc 3.18 skips every factorization after one that failed, and says nothing; so the next one shall be the first.
    check(PCReset(pc));
    check(PCSetOperators(pc, K, K));
    control_mumps(pc, K, workspace);
  }
  check(PCSetReusePreconditioner(pc, PETSC_TRUE));
  return is_sound;
}

std::string mumps_version() {
  return MUMPS_VERSION;
}

std::optional<PetscInt> negative_pivots(PC pc) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(pc, PCCHOLESKY, &factor)) return std::nullopt;
  PetscInt negative = 0;
  check(MatGetInertia(factor, &negative, nullptr, nullptr));
  return negative;
}

}  // namespace pliant
