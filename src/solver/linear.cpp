#include "solver/linear.hpp"

#include "petsc/array_view.hpp"

#include <array>

#include <dmumps_c.h>

namespace pliant {
namespace {

/// Beyond this many unknowns the fill of a factorization costs more than the iterations of CG + GAMG.
constexpr PetscInt max_unknowns_of_factorization = 60000;

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

/// Three translations and three rotations of the reference configuration, zero on prescribed entries: what coarse
/// levels must represent.
void set_near_null_space(Mat K, const NodeLayout& layout, const std::vector<char>& prescribed) {
  std::array<Handle<Vec>, 6> modes;
  std::array<Vec, 6> raw;
  for (int m = 0; m < 6; ++m) {
    check(MatCreateVecs(K, modes[m].out(), nullptr));
    raw[m] = modes[m].get();
    const ArrayView mode(raw[m]);
    for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
      const auto X = layout.position(a);
      std::array<double, 3> u{};
      if (m < 3) {
        u[m] = 1.0;
      } else {
        const int i = m - 3, j = (i + 1) % 3, k = (i + 2) % 3;
        u[j] = -X[k];
        u[k] = X[j];
      }
      for (int i = 0; i < 3; ++i) mode[3 * a + i] = prescribed[3 * a + i] ? 0.0 : u[i];
    }
  }
  // Modified Gram-Schmidt; modes that the prescribed entries leave nothing of are dropped.
  std::vector<Vec> kept;
  for (Vec v : raw) {
    PetscReal before = 0.0, after = 0.0;
    check(VecNorm(v, NORM_2, &before));
    for (Vec w : kept) {
      PetscScalar product = 0.0;
      check(VecDot(v, w, &product));
      check(VecAXPY(v, -product, w));
    }
    check(VecNorm(v, NORM_2, &after));
    if (after <= 1e-10 * before || before == 0.0) continue;
    check(VecScale(v, 1.0 / after));
    kept.push_back(v);
  }
  Handle<MatNullSpace> space;
  check(MatNullSpaceCreate(layout.comm, PETSC_FALSE, static_cast<PetscInt>(kept.size()), kept.data(), space.out()));
  check(MatSetNearNullSpace(K, space.get()));
}

}  // namespace

LinearKind automatic_linear_kind(const NodeLayout& layout) {
  return 3 * layout.num_global_nodes <= max_unknowns_of_factorization ? LinearKind::cholesky : LinearKind::amg;
}

std::string describe(LinearKind kind) {
  return kind == LinearKind::cholesky ? "MUMPS LDL^T factorization"
                                      : "conjugate gradients with algebraic multigrid (GAMG)";
}

void configure_linear_solver(KSP ksp, Mat K, LinearKind kind, const NodeLayout& layout,
                             const std::vector<char>& prescribed) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(KSPSetOperators(ksp, K, K));
  if (kind == LinearKind::cholesky) {
    check(KSPSetType(ksp, KSPPREONLY));
    check(PCSetType(pc, PCCHOLESKY));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  } else {
    check(KSPSetType(ksp, KSPCG));
    check(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
    check(KSPSetTolerances(ksp, 1e-5, PETSC_DEFAULT, PETSC_DEFAULT, 500));
    check(PCSetType(pc, PCGAMG));
    check(PCGAMGSetReuseInterpolation(pc, PETSC_TRUE));
    set_default_option("-mg_levels_ksp_type", "chebyshev");
    set_default_option("-mg_levels_pc_type", "jacobi");
    set_default_option("-pc_gamg_threshold", "0.01");
    set_near_null_space(K, layout, prescribed);
  }
  check(KSPSetFromOptions(ksp));
  Mat factor = nullptr;
  if (factorizes_with_mumps(ksp, &factor)) {
    check(MatMumpsSetIcntl(factor, 7, 4));    // ordering: PORD; Debian's MUMPS has neither METIS nor SCOTCH
    check(MatMumpsSetIcntl(factor, 13, 1));   // no ScaLAPACK at the root: its pivots would be missing from the inertia
    check(MatMumpsSetIcntl(factor, 14, 40));  // per cent of workspace beyond the estimate
  }
}

std::string mumps_version() { return MUMPS_VERSION; }

PetscInt negative_pivots(KSP ksp) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(ksp, &factor)) return 0;
  PetscInt negative = 0;
  check(MatGetInertia(factor, &negative, nullptr, nullptr));
  return negative;
}

}  // namespace pliant
