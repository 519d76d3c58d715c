#include "solver/factorization.hpp"

#include "petsc/matrix_pattern.hpp"

#include <algorithm>
#include <string>

namespace pliant {
namespace {

/// Cost of a set-up in iterations, from the operations per entry of the factor. Measured on two beams: 16 for 480
/// operations, 24 for 1100.
constexpr double cost_of_small_factorization = 8.0, cost_per_operation = 0.017;

/// Sets an option that the user has not given. The look-up marks it as used, whether or not there is a solve.
void set_default_option(const char* name, const char* value) {
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, name, &given));
  if (given) return;
  check(PetscOptionsSetValue(nullptr, name, value));
  check(PetscOptionsHasName(nullptr, nullptr, name, &given));
}

/// Whether the preconditioner is a factorization of that type (PCCHOLESKY or PCLU) by MUMPS; its factor.
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

}  // namespace

void use_algebraic_multigrid(PC pc) {
  set_default_option("-mg_levels_ksp_type", "chebyshev");
  set_default_option("-mg_levels_pc_type", "jacobi");
  check(PCSetType(pc, PCGAMG));
  check(PCGAMGSetReuseInterpolation(pc, PETSC_TRUE));
  PetscReal threshold = 0.01;
  check(PCGAMGSetThreshold(pc, &threshold, 1));
}

void control_mumps(PC pc, Mat K, PetscInt workspace, int ordering) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(pc, &factor)) return;
  // PORD aborts the process if all unknowns are coupled with all others (a rigid body, a single cell).
  PetscInt num_unknowns = 0;
  check(MatGetSize(K, &num_unknowns, nullptr));
  check(MatMumpsSetIcntl(factor, 7, num_unknowns < min_unknowns_of_pord ? approximate_minimum_degree : ordering));
  check(MatMumpsSetIcntl(factor, 13, 1));  // no ScaLAPACK at the root: its pivots would be missing from the inertia
  check(MatMumpsSetIcntl(factor, 14, workspace));
}

SetUp set_up_with_workspace(PC pc, Mat K, int ordering) {
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
  check(PCSetType(pc, is_symmetric(symmetry) ? PCCHOLESKY : PCLU));
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
}

std::optional<PetscInt> negative_pivots_of_petsc(PC pc) {
  Mat factor = nullptr;
  if (!factorizes_with_mumps(pc, PCCHOLESKY, &factor)) return std::nullopt;
  PetscInt negative = 0;
  check(MatGetInertia(factor, &negative, nullptr, nullptr));
  return negative;
}

void Factorization::set_up(Mat K) {
  if (kind_ == Kind::factors && !is_multigrid()) factorize(K);
  if (kind_ != Kind::factors || is_multigrid() || outcome_ == SetUp::out_of_memory) set_up_multigrid(K);
  if (kind_ == Kind::adaptive && (outcome_ != SetUp::sound || blocks_ == nullptr)) {
    become_factors();
    set_up(K);
  }
}

void Factorization::become_factors() {
  kind_ = Kind::factors;
  blocks_.reset();
  multigrid_ = {};
  of_multigrid_ = {};
  single_.emplace(symmetry_);
}

void Factorization::set_up_multigrid(Mat K) {
  const bool is_new = !is_multigrid() || pattern_of_multigrid_ != pattern_id(K);
  outcome_ = SetUp::sound;
  if (is_new) {
    single_.reset();
    double_ = {};
    multigrid_ = {};
    pattern_of_multigrid_ = pattern_id(K);
    blocks_ = BlockMultigrid::make(K, P_.get());
    if (blocks_ || kind_ == Kind::adaptive) return;
    make_multigrid_of_petsc(K);
  } else if (blocks_) {
    if (!blocks_->set_up(K)) outcome_ = SetUp::singular;
    return;
  }
  check(MatCopy(K, of_multigrid_.get(), SAME_NONZERO_PATTERN));
  check(PCSetOperators(multigrid_.get(), of_multigrid_.get(), of_multigrid_.get()));
  check(PCSetUp(multigrid_.get()));
  PCFailedReason failure = PC_NOERROR;
  check(PCGetFailedReason(multigrid_.get(), &failure));
  if (failure == PC_NOERROR) return;
  outcome_ = SetUp::singular;
  check(PCReset(multigrid_.get()));  // as in set_up_with_workspace
}

void Factorization::apply(Vec b, Vec x) {
  if (single_) return single_->solve(b, x);
  if (blocks_) return blocks_->apply(b, x);
  check(PCApply(other().get(), b, x));
}

bool Factorization::apply(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
  if (single_) return single_->solve(b, x);
  if (!blocks_) return false;
  blocks_->apply(b, x);
  return true;
}

std::optional<PetscInt> Factorization::negative_pivots() const {
  if (!is_symmetric(symmetry_) || is_multigrid()) return std::nullopt;
  return single_ ? single_->negative_pivots() : negative_pivots_of_petsc(double_.get());
}

double Factorization::cost_of_set_up() const {
  if (!single_) return cost_of_usual_set_up;
  const auto size = single_->size();
  return cost_of_small_factorization + cost_per_operation * size.flops / std::max(size.entries, 1.0);
}

void Factorization::view(PetscViewer viewer) const {
  if (blocks_) {
    return check(PetscViewerASCIIPrintf(viewer,
                                        "    levels %d, entries of their matrices over those of the finest %.3g\n",
                                        blocks_->num_levels(), blocks_->operator_complexity()));
  }
  if (!single_) return check(PCView(other().get(), viewer));
  if (outcome_ != SetUp::sound) return;
  const auto size = single_->size();
  check(PetscViewerASCIIPrintf(viewer, "    entries of the factors %.3g, operations %.3g, ordering (ICNTL(7)) %d\n",
                               size.entries, size.flops, size.ordering));
}

const char* Factorization::name() const {
  if (is_replaced()) return "algebraic multigrid, because there is too little memory for a factorization";
  if (kind_ != Kind::factors)
    return blocks_ ? "smoothed aggregation in single precision" : "algebraic multigrid (GAMG)";
  return single_ ? "MUMPS factorization in single precision" : "MUMPS factorization in double precision";
}

bool Factorization::refine() {
  if (kind_ == Kind::adaptive) {
    become_factors();
    return true;
  }
  if (is_multigrid() || ordering_ != pord) return false;
  if (is_of_symmetric_part()) {
    factorize_whole();
  } else if (single_) {
    single_.reset();
  } else {
    ordering_ = approximate_minimum_fill;
  }
  double_ = {};
  return true;
}

void Factorization::forget() {
  const bool is_as_given = single_ && symmetry_ == given_symmetry_ && kind_ == given_kind_;
  if (is_as_given || is_replaced()) return;
  symmetry_ = given_symmetry_;
  kind_ = given_kind_;
  single_.reset();
  blocks_.reset();
  double_ = {};
  multigrid_ = {};
  of_multigrid_ = {};
  ordering_ = pord;
  if (kind_ == Kind::factors) single_.emplace(symmetry_);
}

void Factorization::factorize_whole() {
  symmetry_ = Symmetry::unsymmetric;
  single_.emplace(symmetry_);
}

void Factorization::factorize(Mat K) {
  if (!single_) {
    if (!double_ || pattern_of_double_ != pattern_id(K)) make_double(K);
    check(PCSetReusePreconditioner(double_.get(), PETSC_FALSE));
    outcome_ = set_up_with_workspace(double_.get(), K, ordering_);
    keep(double_.get());
    return;
  }
  outcome_ = single_->factorize(K);
  if (outcome_ == SetUp::singular && is_of_symmetric_part()) {
    factorize_whole();
    outcome_ = single_->factorize(K);
  }
  const bool is_sound = outcome_ == SetUp::sound;
  if (outcome_ == SetUp::out_of_memory || (is_sound && single_->negative_pivots() == 0)) return;
  if (is_sound && indefinite_ == Indefinite::accepted) return;
  // Singular or indefinite in single precision. If K is definite in double precision, single precision is not
  // accurate enough for this body, and double precision is used from here on.
  make_double(K);
  const SetUp of_double = set_up_with_workspace(double_.get(), K);
  if (of_double == SetUp::sound && (!is_sound || negative_pivots_of_petsc(double_.get()) == 0)) {
    single_.reset();
    outcome_ = SetUp::sound;
    keep(double_.get());
  } else {
    double_ = {};
    if (!is_sound) outcome_ = of_double;
  }
}

void Factorization::make_double(Mat K) {
  pattern_of_double_ = pattern_id(K);
  check(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(K)), double_.out()));
  use_double_precision(double_.get(), symmetry_);
  check(PCSetOperators(double_.get(), K, K));
  control_mumps(double_.get(), K, first_workspace, ordering_);
}

void Factorization::make_multigrid_of_petsc(Mat K) {
  check(MatDuplicate(K, MAT_COPY_VALUES, of_multigrid_.out()));
  check(MatPropagateSymmetryOptions(K, of_multigrid_.get()));
  MatNullSpace near = nullptr;
  check(MatGetNearNullSpace(K, &near));
  check(MatSetNearNullSpace(of_multigrid_.get(), near));
  check(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(K)), multigrid_.out()));
  use_algebraic_multigrid(multigrid_.get());
}

}  // namespace pliant
