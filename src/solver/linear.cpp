#include "solver/linear.hpp"

#include "petsc/callback.hpp"
#include "petsc/matrix_pattern.hpp"

#include <algorithm>
#include <dmumps_c.h>
#include <memory>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Cost of a set-up in iterations: for multigrid and for factorizations that do not report their size; for those that
/// do, from the operations per entry of the factor. Measured on two beams: 16 for 480 operations, 24 for 1100.
constexpr double cost_of_usual_set_up = 16.0, cost_of_small_factorization = 8.0, cost_per_operation = 0.017;
/// Vectors that GMRES keeps before it restarts. With a factor it needs a few, with multigrid some tens.
constexpr PetscInt gmres_restart = 60;

/// Iterations of the Krylov method after which a direction is used as it is. A factor that needs so many should be
/// renewed.
constexpr PetscInt max_iterations_with_factor = 100, max_iterations_of_multigrid = 500;

/// Sets an option that the user has not given. The look-up marks it as used, whether or not there is a solve.
void set_default_option(const char* name, const char* value) {
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, name, &given));
  if (given) return;
  check(PetscOptionsSetValue(nullptr, name, value));
  check(PetscOptionsHasName(nullptr, nullptr, name, &given));
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

void use_algebraic_multigrid(PC pc) {
  set_default_option("-mg_levels_ksp_type", "chebyshev");
  set_default_option("-mg_levels_pc_type", "jacobi");
  check(PCSetType(pc, PCGAMG));
  check(PCGAMGSetReuseInterpolation(pc, PETSC_TRUE));
  PetscReal threshold = 0.01;
  check(PCGAMGSetThreshold(pc, &threshold, 1));
}

/// `workspace`: beyond MUMPS's estimate [per cent].
void control_mumps(PC pc, Mat K, PetscInt workspace, int ordering = pord) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(pc, &factor)) return;
  // PORD aborts the process if all unknowns are coupled with all others (a rigid body, a single cell).
  PetscInt num_unknowns = 0;
  check(MatGetSize(K, &num_unknowns, nullptr));
  check(MatMumpsSetIcntl(factor, 7, num_unknowns < min_unknowns_of_pord ? approximate_minimum_degree : ordering));
  check(MatMumpsSetIcntl(factor, 13, 1));  // no ScaLAPACK at the root: its pivots would be missing from the inertia
  check(MatMumpsSetIcntl(factor, 14, workspace));
}

/// Sets up a preconditioner of PETSc's; a factorization that runs out of workspace is repeated with more.
SetUp set_up_with_workspace(PC pc, Mat K, int ordering = pord) {
  check(PCSetOperators(pc, K, K));
  SetUp outcome = SetUp::singular;
  bool may_help = true;
  for (PetscInt workspace = first_workspace; may_help && workspace <= last_workspace;) {
    check(PCSetUp(pc));
    PCFailedReason failure = PC_NOERROR;
    check(PCGetFailedReason(pc, &failure));
    if (failure == PC_NOERROR) return SetUp::sound;
    Mat factor = nullptr;
    PetscInt error = 0;
    if (factorizes_with_mumps(pc, &factor)) check(MatMumpsGetInfog(factor, 1, &error));
    may_help = lacks_workspace(static_cast<int>(error));
    const bool lacks_memory =
        failure == PC_FACTOR_OUTMEMORY || outcome_of_mumps(static_cast<int>(error)) == SetUp::out_of_memory;
    outcome = lacks_memory ? SetUp::out_of_memory : SetUp::singular;
    if (may_help) workspace *= 4;
    // PETSc 3.18 silently skips every factorization after one that failed; a reset makes the next one the first.
    check(PCReset(pc));
    check(PCSetOperators(pc, K, K));
    control_mumps(pc, K, workspace, ordering);
  }
  return outcome;
}

void use_double_precision(PC pc, Symmetry symmetry) {
  check(PCSetType(pc, symmetry == Symmetry::unsymmetric ? PCLU : PCCHOLESKY));
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
}

/// A factorization in single precision while that is accurate enough, then in double; multigrid if memory is too small.
class Factorization {
 public:
  explicit Factorization(Symmetry symmetry) : symmetry_(symmetry), single_(std::in_place, symmetry) {}

  void set_up(Mat K) {
    if (!multigrid_) factorize(K);
    if (outcome_ == SetUp::out_of_memory || (multigrid_ && pattern_of_multigrid_ != pattern_id(K))) make_multigrid(K);
    if (!multigrid_) return;
    check(MatCopy(K, of_multigrid_.get(), SAME_NONZERO_PATTERN));
    check(PCSetOperators(multigrid_.get(), of_multigrid_.get(), of_multigrid_.get()));
    check(PCSetUp(multigrid_.get()));
    outcome_ = SetUp::sound;
  }
  void apply(Vec b, Vec x) { single_ ? single_->solve(b, x) : check(PCApply(other().get(), b, x)); }
  std::optional<PetscInt> negative_pivots() const {
    if (symmetry_ == Symmetry::unsymmetric || multigrid_) return std::nullopt;
    return single_ ? single_->negative_pivots() : pliant::negative_pivots(double_.get());
  }
  SetUp outcome() const { return outcome_; }
  double cost_of_set_up() const {
    if (!single_) return cost_of_usual_set_up;
    const auto size = single_->size();
    return cost_of_small_factorization + cost_per_operation * size.flops / std::max(size.entries, 1.0);
  }
  void view(PetscViewer viewer) const {
    if (!single_) return check(PCView(other().get(), viewer));
    if (outcome_ != SetUp::sound) return;
    const auto size = single_->size();
    check(PetscViewerASCIIPrintf(viewer, "    entries of the factors %.3g, operations %.3g, ordering (ICNTL(7)) %d\n",
                                 size.entries, size.flops, size.ordering));
  }
  const char* name() const {
    if (multigrid_) return "algebraic multigrid, because there is too little memory for a factorization";
    return single_ ? "MUMPS factorization in single precision" : "MUMPS factorization in double precision";
  }
  bool is_multigrid() const { return static_cast<bool>(multigrid_); }

  bool refine() {
    if (multigrid_ || ordering_ != pord) return false;
    if (single_) {
      single_.reset();
    } else {
      ordering_ = approximate_minimum_fill;
    }
    double_ = {};
    return true;
  }

 private:
  const Handle<PC>& other() const { return multigrid_ ? multigrid_ : double_; }

  void factorize(Mat K) {
    if (!single_) {
      if (!double_ || pattern_of_double_ != pattern_id(K)) make_double(K);
      check(PCSetReusePreconditioner(double_.get(), PETSC_FALSE));
      outcome_ = set_up_with_workspace(double_.get(), K, ordering_);
      keep(double_.get());
      return;
    }
    outcome_ = single_->factorize(K);
    const bool is_sound = outcome_ == SetUp::sound;
    if (outcome_ == SetUp::out_of_memory || (is_sound && single_->negative_pivots() == 0)) return;
    // Singular or indefinite in single precision. If K is definite in double precision, single precision is not
    // accurate enough for this body, and double precision is used from here on.
    make_double(K);
    const SetUp of_double = set_up_with_workspace(double_.get(), K);
    if (of_double == SetUp::sound && (!is_sound || pliant::negative_pivots(double_.get()) == 0)) {
      single_.reset();
      outcome_ = SetUp::sound;
      keep(double_.get());
    } else {
      double_ = {};
      if (!is_sound) outcome_ = of_double;
    }
  }

  /// Keeps the factors of K until the next set-up, although K changes: PETSc would factorize anew at the next solve.
  static void keep(PC pc) { check(PCSetReusePreconditioner(pc, PETSC_TRUE)); }

  void make_double(Mat K) {
    pattern_of_double_ = pattern_id(K);
    check(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(K)), double_.out()));
    use_double_precision(double_.get(), symmetry_);
    check(PCSetOperators(double_.get(), K, K));
    control_mumps(double_.get(), K, first_workspace, ordering_);
  }

  /// Works on a copy of K: like a factorization, it belongs to the matrix of the last set-up.
  void make_multigrid(Mat K) {
    single_.reset();
    double_ = {};
    pattern_of_multigrid_ = pattern_id(K);
    check(MatDuplicate(K, MAT_COPY_VALUES, of_multigrid_.out()));
    check(MatPropagateSymmetryOptions(K, of_multigrid_.get()));
    MatNullSpace near = nullptr;
    check(MatGetNearNullSpace(K, &near));
    check(MatSetNearNullSpace(of_multigrid_.get(), near));
    check(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(K)), multigrid_.out()));
    use_algebraic_multigrid(multigrid_.get());
  }

  Symmetry symmetry_;
  // One of them.
  std::optional<SingleFactorization> single_;
  Handle<PC> double_, multigrid_;
  PetscObjectId pattern_of_double_ = 0;
  Handle<Mat> of_multigrid_;
  PetscObjectId pattern_of_multigrid_ = 0;
  SetUp outcome_ = SetUp::singular;
  int ordering_ = pord;
};

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

void use_factorization(PC pc, Symmetry symmetry) {
  auto factorization = std::make_unique<Factorization>(symmetry);
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetName(pc, factorization->name()));
  check(PCShellSetContext(pc, factorization.release()));
  check(PCShellSetSetUp(pc, set_up_callback));
  check(PCShellSetApply(pc, apply_callback));
  check(PCShellSetView(pc, view_callback));
  check(PCShellSetDestroy(pc, destroy_callback));
}

/// P^T K P, with the rigid-body modes as functions of the coarse space.
Handle<Mat> coarse_operator(Mat K, Mat P, MatNullSpace near_null) {
  Handle<Mat> linear;
  check(MatPtAP(K, P, MAT_INITIAL_MATRIX, PETSC_DEFAULT, linear.out()));
  check(MatSetOption(linear.get(), MAT_SYMMETRIC, PETSC_TRUE));
  check(MatSetOption(linear.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  check(MatSetNearNullSpace(linear.get(), near_null));
  return linear;
}

/// Two levels, quadratic and linear elements: Chebyshev smoothing on the first (Adams et al. 2003, "Parallel multigrid
/// smoothing: polynomial versus Gauss-Seidel"), and on the second a factorization, or algebraic multigrid if a
/// factorization would be too large.
void use_p_multigrid(PC pc, Mat K, const Coarsening& coarsening) {
  Mat P = coarsening.prolongation.get();
  check(PCSetType(pc, PCMG));
  check(PCMGSetLevels(pc, 2, nullptr));
  check(PCMGSetGalerkin(pc, PC_MG_GALERKIN_NONE));
  check(PCMGSetInterpolation(pc, 1, P));
  KSP smoother = nullptr, coarse = nullptr;
  PC of_smoother = nullptr, of_coarse = nullptr;
  check(PCMGGetSmoother(pc, 1, &smoother));
  check(KSPSetType(smoother, KSPCHEBYSHEV));
  check(KSPGetPC(smoother, &of_smoother));
  check(PCSetType(of_smoother, PCJACOBI));
  check(PCMGGetCoarseSolve(pc, &coarse));
  check(KSPSetType(coarse, KSPPREONLY));
  const Handle<Mat> linear = coarse_operator(K, P, coarsening.near_null.get());
  check(KSPSetOperators(coarse, linear.get(), linear.get()));
  check(KSPGetPC(coarse, &of_coarse));
  PetscInt num_unknowns = 0;
  check(MatGetSize(linear.get(), &num_unknowns, nullptr));
  if (automatic_linear_kind(num_unknowns, 1) == LinearKind::cholesky) {
    use_factorization(of_coarse, Symmetry::symmetric);
  } else {
    use_algebraic_multigrid(of_coarse);
  }
}

bool is_p_multigrid(PC pc) {
  PetscBool is_multigrid = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCMG, &is_multigrid));
  PetscInt num_levels = 0;
  if (is_multigrid) check(PCMGGetLevels(pc, &num_levels));
  return num_levels == 2;
}

/// Prepares one of PETSc's preconditioners for a matrix with another pattern.
void renew(PC pc, Mat K) {
  PetscBool is_gamg = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &is_gamg));
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

/// Updates the operator of the coarse level from the fine one; PCs without levels are left unchanged.
void update_coarse_level(PC pc, Mat K, bool is_new_pattern) {
  if (!is_p_multigrid(pc)) return;
  Mat P = nullptr, linear = nullptr;
  KSP coarse = nullptr;
  check(PCMGGetInterpolation(pc, 1, &P));
  check(PCMGGetCoarseSolve(pc, &coarse));
  check(KSPGetOperators(coarse, &linear, nullptr));
  Handle<Mat> renewed;
  if (is_new_pattern) {
    MatNullSpace near_null = nullptr;
    check(MatGetNearNullSpace(linear, &near_null));
    renewed = coarse_operator(K, P, near_null);
    linear = renewed.get();
    PC of_coarse = nullptr;
    check(KSPGetPC(coarse, &of_coarse));
    if (factorization_of(of_coarse) == nullptr) renew(of_coarse, linear);
  } else {
    check(MatPtAP(K, P, MAT_REUSE_MATRIX, PETSC_DEFAULT, &linear));
  }
  check(KSPSetOperators(coarse, linear, linear));
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
  (void)takes_new_pattern(reinterpret_cast<PetscObject>(pc), K);  // that of the coarse level below
  const bool may_be_single = kind == LinearKind::cholesky && symmetry != Symmetry::indefinite;
  check(KSPSetTolerances(ksp, 1e-5, PETSC_DEFAULT, PETSC_DEFAULT,
                         kind == LinearKind::cholesky ? max_iterations_with_factor : max_iterations_of_multigrid));
  if (may_be_single) {
    use_factorization(pc, symmetry);
  } else if (kind == LinearKind::cholesky) {
    use_double_precision(pc, symmetry);
  } else if (coarsening != nullptr && symmetry == Symmetry::symmetric) {
    use_p_multigrid(pc, K, *coarsening);
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

SetUp set_up_preconditioner(PC pc, Mat K) {
  check(PCSetReusePreconditioner(pc, PETSC_FALSE));
  const bool is_new_pattern = takes_new_pattern(reinterpret_cast<PetscObject>(pc), K);
  // The p-multigrid set up here keeps its levels; nothing in PETSc's own preconditioners would fit the new pattern.
  if (is_new_pattern && factorization_of(pc) == nullptr && !is_p_multigrid(pc)) renew(pc, K);
  check(PCSetOperators(pc, K, K));
  update_coarse_level(pc, K, is_new_pattern);
  SetUp outcome = SetUp::sound;
  if (const Factorization* factorization = factorization_of(pc)) {
    check(PCSetUp(pc));
    outcome = factorization->outcome();
  } else {
    outcome = set_up_with_workspace(pc, K);
  }
  check(PCSetReusePreconditioner(pc, PETSC_TRUE));
  return outcome;
}

bool refine_factorization(PC pc) {
  Factorization* factorization = factorization_of(pc);
  if (factorization == nullptr || !factorization->refine()) return false;
  check(PCReset(pc));  // PETSc skips the set-up for a matrix that it already knows
  return true;
}

bool uses_multigrid_instead(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr && factorization->is_multigrid();
}

double cost_of_set_up(PC pc) {
  const Factorization* factorization = factorization_of(pc);
  return factorization != nullptr ? factorization->cost_of_set_up() : cost_of_usual_set_up;
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
  Mat factor = nullptr;
  if (!factorizes_with_mumps(pc, PCCHOLESKY, &factor)) return std::nullopt;
  PetscInt negative = 0;
  check(MatGetInertia(factor, &negative, nullptr, nullptr));
  return negative;
}

}  // namespace pliant
