#include "solver/linear.hpp"

#include "energy/equation/saddle_point.hpp"
#include "petsc/callback.hpp"
#include "petsc/matrix_pattern.hpp"
#include "solver/factorization.hpp"

#include <algorithm>
#include <dmumps_c.h>
#include <memory>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Vectors that GMRES keeps before it restarts. With a factor it needs a few, with multigrid some tens.
constexpr PetscInt gmres_restart = 60;

/// Iterations of the Krylov method after which a direction is used as it is. A factor that needs so many should be
/// renewed.
constexpr PetscInt max_iterations_with_factor = 100, max_iterations_of_multigrid = 500;

/// The Factorization behind a preconditioner; nullptr if it is of another type.
Factorization* factorization_of(PC pc) {
  PetscBool is_shell = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCSHELL, &is_shell));
  Factorization* factorization = nullptr;
  if (is_shell) check(PCShellGetContext(pc, &factorization));
  return factorization;
}

PetscErrorCode set_up_callback(PC pc) {
  return CallbackGuard().run([&] {
    Mat K = nullptr;
    check(PCGetOperators(pc, nullptr, &K));
    Factorization* factorization = factorization_of(pc);
    factorization->set_up(K);
    check(PCShellSetName(pc, factorization->name()));
    check(PCSetFailedReason(pc, factorization->outcome() == SetUp::sound ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
  });
}

PetscErrorCode apply_callback(PC pc, Vec b, Vec x) {
  return CallbackGuard().run([&] { factorization_of(pc)->apply(b, x); });
}

PetscErrorCode view_callback(PC pc, PetscViewer viewer) {
  return CallbackGuard().run([&] { factorization_of(pc)->view(viewer); });
}

PetscErrorCode destroy_callback(PC pc) {
  return CallbackGuard().run([&] { delete factorization_of(pc); });
}

/// Whether our own multigrid can be made for K.
bool has_near_null_modes(Mat K) {
  MatNullSpace modes = nullptr;
  check(MatGetNearNullSpace(K, &modes));
  return modes != nullptr;
}

void use_factorization(PC pc, Symmetry symmetry, Factorization::Kind kind, Mat P = nullptr) {
  auto factorization = std::make_unique<Factorization>(symmetry, kind, P);
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetName(pc, factorization->name()));
  check(PCShellSetContext(pc, factorization.release()));
  check(PCShellSetSetUp(pc, set_up_callback));
  check(PCShellSetApply(pc, apply_callback));
  check(PCShellSetView(pc, view_callback));
  check(PCShellSetDestroy(pc, destroy_callback));
}

/// Displacements by algebraic multigrid, then pressures by their approximate Schur complement.
void use_split(PC pc, const SaddlePointParts& parts) {
  check(PCSetType(pc, PCFIELDSPLIT));
  check(PCFieldSplitSetIS(pc, "displacements", parts.displacements));
  check(PCFieldSplitSetIS(pc, "pressures", parts.pressures));
  check(PCFieldSplitSetType(pc, PC_COMPOSITE_SCHUR));
  check(PCFieldSplitSetSchurFactType(pc, PC_FIELDSPLIT_SCHUR_FACT_UPPER));
  check(PCFieldSplitSetSchurPre(pc, PC_FIELDSPLIT_SCHUR_PRE_USER, parts.schur));
}

/// Chooses the solvers of the parts, which exist once the preconditioner has been set up.
void choose_solvers_of_parts(PC pc) {
  PetscBool is_split = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCFIELDSPLIT, &is_split));
  if (!is_split) return;
  PetscInt num_parts = 0;
  KSP* parts = nullptr;
  check(PCFieldSplitSchurGetSubKSP(pc, &num_parts, &parts));
  for (PetscInt part = 0; part < num_parts; ++part) {
    PC of_part = nullptr;
    PetscBool is_chosen = PETSC_FALSE;
    check(KSPGetPC(parts[part], &of_part));
    check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(of_part), &is_chosen, PCGAMG, PCJACOBI, ""));
    if (is_chosen) continue;
    check(KSPSetType(parts[part], KSPPREONLY));
    if (part == 0) {
      use_algebraic_multigrid(of_part);
    } else {
      check(PCSetType(of_part, PCJACOBI));
    }
    check(KSPSetFromOptions(parts[part]));
  }
  check(PetscFree(parts));
}

/// Prepares one of PETSc's preconditioners for a matrix with another pattern.
void renew(PC pc, Mat K) {
  PetscBool is_gamg = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &is_gamg));
  if (const auto parts = saddle_point_of(K); parts && !is_factorization(pc)) {
    check(PCSetType(pc, PCNONE));  // its parts would keep their old patterns
    use_split(pc, *parts);
    check(PCSetFromOptions(pc));
    return;
  }
  if (!is_gamg) {
    check(PCReset(pc));
    check(PCSetOperators(pc, K, K));  // the reset has dropped them, and MUMPS is chosen by the matrix
    control_mumps(pc, K, first_workspace);
    return;
  }
  check(PCSetType(pc, PCNONE));  // its levels would keep their old sizes
  use_algebraic_multigrid(pc);
  check(PCSetFromOptions(pc));
}

}  // namespace

void set_krylov_method(KSP ksp, Symmetry symmetry) {
  if (symmetry == Symmetry::symmetric) {
    check(KSPSetType(ksp, KSPCG));
    check(KSPSetPCSide(ksp, PC_LEFT));
  } else {
    PC pc = nullptr;
    PetscBool is_ours = PETSC_FALSE;
    check(KSPGetPC(ksp, &pc));
    check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCSHELL, &is_ours));
    // Flexible GMRES if the preconditioner works in single precision, which makes it linear only up to rounding errors.
    // Preconditioned on the right, so that the residual is that of the system.
    check(KSPSetType(ksp, is_ours ? KSPFGMRES : KSPGMRES));
    check(KSPSetPCSide(ksp, PC_RIGHT));
    check(KSPGMRESSetRestart(ksp, gmres_restart));
  }
  check(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
}

void configure_linear_solver(KSP ksp, Mat K, LinearKind kind, Symmetry symmetry, const Coarsening* coarsening) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(KSPSetOperators(ksp, K, K));
  (void)takes_new_pattern(reinterpret_cast<PetscObject>(pc), K);
  const bool may_be_single = kind == LinearKind::cholesky && symmetry != Symmetry::indefinite;
  check(KSPSetTolerances(ksp, 1e-5, PETSC_DEFAULT, PETSC_DEFAULT,
                         kind == LinearKind::cholesky ? max_iterations_with_factor : max_iterations_of_multigrid));
  if (may_be_single) {
    use_factorization(pc, symmetry, Factorization::Kind::factors);
  } else if (kind == LinearKind::cholesky) {
    use_double_precision(pc, symmetry);
  } else if (const auto parts = saddle_point_of(K)) {
    use_split(pc, *parts);
  } else if (is_symmetric(symmetry) || has_near_null_modes(K)) {
    const bool is_adaptive = kind == LinearKind::adaptive;
    use_factorization(pc, symmetry, is_adaptive ? Factorization::Kind::adaptive : Factorization::Kind::multigrid,
                      coarsening != nullptr ? coarsening->prolongation.get() : nullptr);
  } else {
    use_algebraic_multigrid(pc);
  }
  set_krylov_method(ksp, symmetry);
  check(KSPSetFromOptions(ksp));
  PetscBool solves_directly = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &solves_directly));
  if (solves_directly && factorization_of(pc) != nullptr) use_double_precision(pc, symmetry);
  control_mumps(pc, K, first_workspace);
}

SetUp set_up_preconditioner(PC pc, Mat K, Indefinite indefinite) {
  check(PCSetReusePreconditioner(pc, PETSC_FALSE));
  const bool is_new_pattern = takes_new_pattern(reinterpret_cast<PetscObject>(pc), K);
  // Nothing in PETSc's own preconditioners would fit the new pattern.
  if (is_new_pattern && factorization_of(pc) == nullptr) renew(pc, K);
  check(PCSetOperators(pc, K, K));
  SetUp outcome = SetUp::sound;
  if (Factorization* factorization = factorization_of(pc)) {
    factorization->treat(indefinite);
    check(PCSetUp(pc));
    outcome = factorization->outcome();
  } else {
    outcome = set_up_with_workspace(pc, K);
    choose_solvers_of_parts(pc);
  }
  check(PCSetReusePreconditioner(pc, PETSC_TRUE));
  return outcome;
}

void forget_set_ups(PC pc) {
  if (Factorization* factorization = factorization_of(pc)) {
    factorization->forget();
    check(PCReset(pc));  // as in refine_factorization
  } else if (!is_factorization(pc)) {
    forget_pattern(reinterpret_cast<PetscObject>(pc));
  }
}

bool refine_factorization(PC pc) {
  Factorization* factorization = factorization_of(pc);
  if (factorization == nullptr || !factorization->refine()) return false;
  check(PCReset(pc));  // PETSc skips the set-up for a matrix that it already knows
  return true;
}

bool uses_multigrid_instead(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr && factorization->is_replaced();
}

bool uses_near_null_space(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr && factorization->uses_near_null_space();
}

bool may_become_factorization(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr && factorization->may_become_factors();
}

bool is_of_symmetric_part(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr && factorization->is_of_symmetric_part();
}

bool apply_to_several(PC pc, std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
  Factorization* factorization = factorization_of(pc);
  return factorization != nullptr && factorization->apply(b, x);
}

double cost_of_set_up(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr ? factorization->cost_of_set_up() : cost_of_usual_set_up;
}

bool is_own_preconditioner(PC pc) {
  return factorization_of(pc) != nullptr;
}

bool is_factorization(PC pc) {
  PetscBool is_of_petsc = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &is_of_petsc, PCCHOLESKY, PCLU, ""));
  return is_of_petsc || factorization_of(pc) != nullptr;
}

std::string mumps_version() {
  return MUMPS_VERSION;
}

std::optional<PetscInt> negative_pivots(PC pc) {
  if (const Factorization* factorization = factorization_of(pc)) return factorization->negative_pivots();
  return negative_pivots_of_petsc(pc);
}

}  // namespace pliant
