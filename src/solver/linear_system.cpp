#include "solver/linear_system.hpp"

#include "base/stopwatch.hpp"
#include "petsc/array_view.hpp"
#include "solver/linear.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Shift of the diagonal of an indefinite Hessian, as a fraction of its mean: the smallest, the largest, and the factor
/// by which it grows until the Hessian is definite (as in Waechter & Biegler 2006, "On the implementation of an
/// interior-point filter line-search algorithm", 3.1).
constexpr double largest_shift = 0.1;
struct ShiftSequence {
  double least, growth;
};
constexpr ShiftSequence usual_shifts{1e-6, 8.0};
/// The negative directions of barriers are stiff: small shifts do not help there.
constexpr ShiftSequence shifts_at_walls{1e-3, 30.0};

/// Shift of the diagonal at the end of the fallback sequence, as a fraction of its mean: enough to make a singular
/// projected Hessian definite.
constexpr double regularization = 1e-3;

/// Fraction of a linear system's residual that conjugate gradients may leave when they meet negative curvature.
constexpr double truncated_part = 0.1;

/// Part of the iterations allowed after which conjugate gradients give up a K that is symmetric but for its border.
constexpr int part_as_symmetric = 5;
constexpr int most_in_vain = 6;

bool is_of_type(KSP ksp, KSPType type) {
  PetscBool is = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), type, &is));
  return is == PETSC_TRUE;
}

FactorPolicy::Solver solver_of(KSP ksp) {
  return is_of_type(ksp, KSPPREONLY) ? FactorPolicy::Solver::direct : FactorPolicy::Solver::iterative;
}

/// Whether the last solve met a preconditioner that is far from the inverse of its matrix, as a factor in single
/// precision is along directions that are softer than its rounding errors.
bool is_inverse_wrong(KSP ksp) {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp, &reason));
  return reason == KSP_DIVERGED_DTOL || reason == KSP_DIVERGED_INDEFINITE_PC || reason == KSP_DIVERGED_BREAKDOWN;
}

Handle<PC> shared_preconditioner(KSP ksp) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectReference(reinterpret_cast<PetscObject>(pc)));
  return Handle<PC>(pc);
}

}  // namespace

LinearSystem::LinearSystem(Objective& objective, KSP ksp, Handle<Mat> K, SolverStatistics& statistics)
    : objective_(objective),
      equation_(objective.equation()),
      statistics_(statistics),
      ksp_(ksp),
      K_(std::move(K)),
      preconditioner_(shared_preconditioner(ksp)),
      diagonal_(equation_),
      factor_(solver_of(ksp)),
      may_choose_krylov_(is_of_type(ksp, KSPCG) && equation_.symmetry() == Symmetry::symmetric) {
  for (std::size_t k = 0; k < equation_.num_rank_one(); ++k) parts_.push_back({0.0, equation_.make_vector()});
  if (!parts_.empty()) rank_one_ = std::make_unique<RankOneSystem>(ksp, K_.get(), parts_);
  check(KSPGetTolerances(ksp, nullptr, nullptr, nullptr, &most_iterations_));
  check(PetscOptionsHasName(nullptr, nullptr, "-ksp_type", &krylov_is_chosen_));
  PetscBool rotates = PETSC_TRUE;
  check(PetscOptionsGetBool(nullptr, nullptr, "-newton_turn_factor", &rotates, nullptr));
  // Multigrid smooths with the current K, which has already rotated.
  const bool may_keep = solver_of(ksp) == FactorPolicy::Solver::iterative;
  if (rotates && may_keep && is_factorization(preconditioner_.get())) rotations_ = equation_.make_rotations();
  if (rotations_) corotated_ = std::make_unique<CorotatedPreconditioner>(ksp, *rotations_);
  std::vector<PetscInt> border = equation_.border();
  if (!border.empty() && may_keep && is_own_preconditioner(preconditioner_.get())) {
    bordered_ =
        std::make_unique<BorderedSystem>(ksp, K_.get(), std::move(border), equation_.prescribed(), rotations_.get());
  }
}

void LinearSystem::assemble(Vec q, Projection projection) {
  {
    const Stopwatch watch(statistics_.assembly_seconds);
    objective_.hessian(q, K_.get(), projection);
    if (rank_one_) equation_.rank_one_parts(q, parts_);
  }
  switch (projection) {
    case Projection::none:
      escalation_.begin();
      return;
    case Projection::walls:
      escalation_.barriers_projected();
      break;
    case Projection::positive_semidefinite:
      escalation_.projected();
  }
  ++statistics_.projections;
}

double LinearSystem::mean_diagonal() {
  check(MatGetDiagonal(K_.get(), diagonal_.get()));
  PetscReal total = 0.0;
  check(VecNorm(diagonal_.get(), NORM_1, &total));
  return total / equation_.num_unknowns();
}

void LinearSystem::shift(double by) {
  if (equation_.symmetry() == Symmetry::indefinite) {
    check(MatGetDiagonal(K_.get(), diagonal_.get()));
    {
      const ArrayView diagonal(diagonal_.get());
      for (double& d : diagonal.span()) d = d > 0.0 ? by : -by;  // away from zero on either side
    }
    check(MatDiagonalSet(K_.get(), diagonal_.get(), ADD_VALUES));
  } else {
    check(MatShift(K_.get(), by));
  }
  escalation_.shifted();
  ++statistics_.regularizations;
}

std::optional<PetscInt> LinearSystem::negative_eigenvalues() const {
  std::optional<PetscInt> number = negative_pivots(preconditioner_.get());
  if (number && rank_one_) *number -= rank_one_->negative_eigenvalues();
  return number;
}

bool LinearSystem::has_right_inertia() const {
  return !factor_.has_failed() &&
         negative_eigenvalues().value_or(equation_.num_negative_pivots()) == equation_.num_negative_pivots();
}

std::optional<PetscInt> LinearSystem::unstable_modes() const {
  if (factor_.has_failed()) return std::nullopt;
  std::optional<PetscInt> number = negative_eigenvalues();
  if (number) *number -= equation_.num_negative_pivots();
  return number;
}

// Conjugate gradients keep the residual r - K y itself, so what they end with solves the system whatever the symmetry
// of K; only their pace depends on it. The border makes K unsymmetric by little, and they spare the vectors of GMRES.
void LinearSystem::take_as_symmetric(bool is_taken) {
  if (is_taken == is_taken_as_symmetric_ || !is_of_type(ksp_, is_taken ? KSPFGMRES : KSPCG)) return;
  is_taken_as_symmetric_ = is_taken;
  set_krylov_method(ksp_, is_taken ? Symmetry::symmetric : Symmetry::nearly_symmetric);
  check(KSPSetTolerances(ksp_, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                         is_taken ? most_iterations_ / part_as_symmetric : most_iterations_));
}

void LinearSystem::choose_for_border() {
  if (is_taken_as_symmetric_) num_in_vain_ = 0;
  const bool waits = num_not_symmetric_ > 0;
  if (waits) --num_not_symmetric_;
  take_as_symmetric(!waits && !krylov_is_chosen_ && has_right_inertia());
}

void LinearSystem::choose_krylov_method() {
  if (!may_choose_krylov_) return;
  set_krylov_method(ksp_, has_right_inertia() ? Symmetry::symmetric : Symmetry::indefinite);
}

bool LinearSystem::refine(Vec q) {
  if (!refine_factorization(preconditioner_.get()) || !factorize_definite(q)) return false;
  use_krylov_method_for_indefinite();
  return true;
}

void LinearSystem::use_krylov_method_for_indefinite() {
  if (may_choose_krylov_) set_krylov_method(ksp_, Symmetry::indefinite);
}

void LinearSystem::use_usual_krylov_method() {
  if (may_choose_krylov_) set_krylov_method(ksp_, Symmetry::symmetric);
}

void LinearSystem::forget() {
  last_shift_ = 0.0;
  num_in_vain_ = num_not_symmetric_ = 0;
  take_as_symmetric(false);
  factor_.renew();
  forget_set_ups(preconditioner_.get());
}

void LinearSystem::factorize(Vec q, Indefinite indefinite) {
  const Stopwatch watch(statistics_.factorization_seconds);
  if (uses_near_null_space(preconditioner_.get())) equation_.follow_rigid_motions(q, K_.get());
  factor_.note_set_up(set_up_preconditioner(preconditioner_.get(),
                                            bordered_ ? bordered_->inner_matrix(K_.get()) : K_.get(), indefinite));
  // The next set-up has others; these are six vectors. Factors that multigrid may have to replace later need them.
  if (uses_near_null_space(preconditioner_.get()) && !may_become_factorization(preconditioner_.get())) {
    check(MatSetNearNullSpace(K_.get(), nullptr));
  }
  statistics_.uses_multigrid_instead = uses_multigrid_instead(preconditioner_.get());
  const auto clear_border = [&](Vec x) {
    if (bordered_) bordered_->clear_border(x);
  };
  if (rank_one_ && !factor_.has_failed() && !rank_one_->set_up(clear_border)) factor_.note_failure();
  check(KSPSetOperators(ksp_, matrix(), K_.get()));
  if (rotations_) rotations_->start(equation_.displacements(q));
  if (bordered_ && !factor_.has_failed()) {
    bordered_->set_up(K_.get());
    bordered_->follow(K_.get(), parts_);
  }
  if (bordered_) choose_for_border();
  ++statistics_.factorizations;
  escalation_.factorized();
}

Indefinite LinearSystem::if_indefinite(bool is_likely) const {
  const bool is_changed = objective_.aim() != Aim::any_equilibrium && equation_.num_negative_pivots() == 0;
  return is_likely && is_changed ? Indefinite::accepted : Indefinite::verified;
}

bool LinearSystem::factorize_definite(Vec q) {
  const bool projects_first = equation_.has_walls() && remedy_ == Remedy::projected_walls;
  factorize(q, if_indefinite(projects_first || last_shift_ > 10.0 * usual_shifts.least));
  if (factor_.has_failed()) return false;
  if (objective_.aim() == Aim::any_equilibrium) {
    choose_krylov_method();
    if (!has_right_inertia()) factor_.renew();  // an indefinite factor of another matrix helps GMRES little
    return true;
  }
  if (has_right_inertia()) return true;
  // Shifts that outweigh the negative directions of barriers leave Newton's steps short everywhere else.
  if (projects_first && factorize_with_projected_walls(q)) return true;
  if (factorize_shifted(q)) return true;
  if (factor_.lacks_memory()) return false;
  last_shift_ = 0.0;
  if (!projects_first && equation_.has_walls() && factorize_with_projected_walls(q)) return true;
  assemble(q, Projection::positive_semidefinite);
  factorize(q);
  factor_.renew();
  return !factor_.has_failed();
}

// A small shift of the diagonal leaves stiff modes unchanged, and Newton's direction long along soft or unstable ones.
// On a merit of the residual, a direction that is long along an unstable mode gains nothing.
bool LinearSystem::factorize_shifted(Vec q) {
  if (!objective_.is_minimised() && !objective_.is_static()) return false;
  const bool has_walls = equation_.has_walls() && remedy_ == Remedy::shifted_diagonal;
  const ShiftSequence& shifts = has_walls ? shifts_at_walls : usual_shifts;
  const double mean = mean_diagonal();
  double total = 0.0;
  for (double part = std::max(shifts.least, last_shift_ / 3.0); part <= largest_shift; part *= shifts.growth) {
    shift(part * mean - total);
    total = part * mean;
    factorize(q, if_indefinite(true));
    if (factor_.lacks_memory()) return false;
    if (!has_right_inertia()) continue;
    last_shift_ = part;
    factor_.renew();  // the next Hessian may be definite again
    return true;
  }
  return false;
}

bool LinearSystem::factorize_with_projected_walls(Vec q) {
  assemble(q, Projection::walls);
  factorize(q);
  factor_.renew();
  return projects_walls_ = has_right_inertia();
}

bool LinearSystem::is_stable(Vec q) {
  return has_right_inertia() || (equation_.has_walls() && factorize_with_projected_walls(q));
}

bool LinearSystem::prepare(Vec q, Remedy first) {
  projects_walls_ = false;
  remedy_ = first;
  if (!factor_.wants_factor()) {
    if (rotations_) rotations_->follow(equation_.displacements(q));
    if (bordered_) bordered_->follow(K_.get(), parts_);
    return true;
  }
  factorize_definite(q);
  return !factor_.has_failed() || escalate(q);
}

bool LinearSystem::prepare_with_projected_walls(Vec q) {
  if (factorize_with_projected_walls(q)) return true;
  if (factor_.lacks_memory()) return false;
  assemble(q);
  return prepare(q);
}

bool LinearSystem::escalate(Vec q) {
  using enum Escalation::State;
  do {
    const auto permission = factor_.lacks_memory()                     ? Escalation::Permission::nothing
                            : objective_.aim() == Aim::any_equilibrium ? Escalation::Permission::exact_hessian
                                                                       : Escalation::Permission::anything;
    switch (escalation_.escalate(permission)) {
      case fresh_factor:
        // On the residual, the exact Newton direction is the best, whatever the signs of the eigenvalues.
        objective_.is_minimised() || objective_.is_static() ? static_cast<void>(factorize_definite(q)) : factorize(q);
        break;
      case projected:
        assemble(q, Projection::positive_semidefinite);
        factorize(q);
        factor_.renew();  // the next Hessian may need no projection
        break;
      case projected_and_shifted:
        // Multigrid that fails with a projected Hessian is of no use here.
        if (may_become_factorization(preconditioner_.get())) (void)refine_factorization(preconditioner_.get());
        shift(regularization * mean_diagonal());
        factorize(q);
        factor_.renew();
        break;
      default:
        return false;
    }
  } while (factor_.has_failed());
  return true;
}

FactorPolicy::Factored LinearSystem::what_is_factored() const {
  using enum FactorPolicy::Factored;
  PC pc = preconditioner_.get();
  return may_become_factorization(pc) ? nothing : !bordered_ && is_of_symmetric_part(pc) ? symmetric_part : whole;
}

void LinearSystem::improve_poor_factor(Vec q, Vec r, Vec y) {
  {
    const Stopwatch watch(statistics_.solve_seconds);
    solve_as_unsymmetric(r, y);  // SNES has solved it
  }
  const auto is_poor = [&] {
    if (FactorPolicy::is_poor(last_solve(), whose_factor(), what_is_factored())) return true;
    return !escalation_.has_kept_factor() && !factor_.has_failed() && is_inverse_wrong(ksp_);
  };
  while (is_poor() && refine_factorization(preconditioner_.get())) {
    if (!factorize_definite(q)) return;
    solve(r, y);
  }
}

void LinearSystem::solve(Vec r, Vec y) {
  const Stopwatch watch(statistics_.solve_seconds);
  check(KSPSolve(ksp_, r, y));
  statistics_.linear_iterations += last_iterations();
  solve_as_unsymmetric(r, y);
}

void LinearSystem::solve_as_unsymmetric(Vec r, Vec y) {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  if (!is_taken_as_symmetric_ || reason > 0) return;
  take_as_symmetric(false);
  num_in_vain_ = std::min(num_in_vain_ + 1, most_in_vain);
  num_not_symmetric_ = 1 << num_in_vain_;
  check(KSPSolve(ksp_, r, y));
  statistics_.linear_iterations += last_iterations();
}

bool LinearSystem::solve_several(std::span<const Vec> r, std::span<const Vec> guesses, std::span<const Vec> y,
                                 double part) {
  if (rank_one_ || bordered_ || factor_.has_failed() || !is_of_type(ksp_, KSPCG)) return false;
  const Stopwatch watch(statistics_.solve_seconds);
  const auto inverse = [&](std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
    if (!rotations_) return apply_to_several(preconditioner_.get(), b, x);
    turned_back_.assign(b.begin(), b.end());
    rotations_->turn_back(turned_back_);
    if (!apply_to_several(preconditioner_.get(), turned_back_, x)) return false;
    rotations_->turn(x);
    return true;
  };
  PetscInt most = 0;
  check(KSPGetTolerances(ksp_, nullptr, nullptr, nullptr, &most));
  const auto cost = several_.solve(K_.get(), inverse, r, guesses, y, part, static_cast<int>(most));
  if (!cost) return false;
  statistics_.linear_iterations += cost->iterations * static_cast<PetscInt>(r.size());
  if (cost->iterations == 0) return true;
  const FactorPolicy::Solve done{cost->iterations, cost->digits, pliant::cost_of_set_up(preconditioner_.get())};
  if (FactorPolicy::is_poor(done, whose_factor(), what_is_factored())) return false;
  factor_.note_solve(done, whose_factor());
  return true;
}

PetscInt LinearSystem::last_iterations() const {
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp_, &iterations));
  return iterations;
}

FactorPolicy::Solve LinearSystem::last_solve() const {
  PetscReal tolerance = 0.0;
  check(KSPGetTolerances(ksp_, &tolerance, nullptr, nullptr, nullptr));
  double digits = -std::log10(tolerance);
  if (bordered_) digits = std::max(std::min(digits, 1.0), digits + std::log10(bordered_->part_of_rest()));
  return {static_cast<int>(last_iterations()), digits, cost_of_set_up(preconditioner_.get())};
}

void LinearSystem::note_solve() {
  factor_.note_solve(last_solve(), whose_factor());
}

bool LinearSystem::has_direction(Vec r) const {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  // Conjugate gradients stop at negative curvature and return the iterate before it: a descent direction, and a good
  // one if the linear system is nearly solved (truncated Newton: Nash 1984, "Newton-type minimization via the Lanczos
  // method").
  if (reason == KSP_DIVERGED_INDEFINITE_MAT) {
    PetscReal left = 0.0;
    check(KSPGetResidualNorm(ksp_, &left));
    return !(left > truncated_part * norm(r));
  }
  if (reason == KSP_DIVERGED_ITS)  // a poor direction, not a wrong one
    return !(objective_.aim() == Aim::whole_steps && escalation_.has_kept_factor());
  return reason >= 0;
}

}  // namespace pliant
