// The linear systems of NewtonSolver: their matrices, and what is done where they are indefinite.
#include "base/stopwatch.hpp"
#include "petsc/array_view.hpp"
#include "solver/newton.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// What is added to the diagonal of an indefinite Hessian, as a part of its mean: the least, the most, and how many
/// times more each time until it is definite (as in Waechter & Biegler 2006, "On the implementation of an
/// interior-point filter line-search algorithm", 3.1).
constexpr double least_shift = 1e-6, largest_shift = 0.1, shift_growth = 8.0;
/// Of linear systems whose solutions are steps to be taken whole: what they leave in stiff directions, a step in soft
/// ones turns into forces.
constexpr double tolerance_of_whole_steps = 1e-8;
}  // namespace

void NewtonSolver::assemble(Vec q, Projection projection) {
  {
    const Stopwatch watch(statistics_.assembly_seconds);
    equation_.hessian(q, K_.get(), projection);
    proximal_.add_hessian(K_.get());
    if (rank_one_system_) equation_.rank_one_parts(q, rank_one_);
  }
  factor_is_current_ = false;
  if (projection != Projection::none) ++statistics_.projections;
  projection_ = projection;
  is_regularized_ = false;
}

double NewtonSolver::mean_diagonal() {
  check(MatGetDiagonal(K_.get(), trial_.get()));
  PetscReal total = 0.0;
  check(VecNorm(trial_.get(), NORM_1, &total));
  return total / equation_.num_unknowns();
}

void NewtonSolver::shift(double by) {
  if (equation_.symmetry() == Symmetry::indefinite) {
    check(MatGetDiagonal(K_.get(), trial_.get()));
    {
      const ArrayView diagonal(trial_.get());
      for (double& d : diagonal.span()) d = d > 0.0 ? by : -by;  // away from zero on either side
    }
    check(MatDiagonalSet(K_.get(), trial_.get(), ADD_VALUES));
  } else {
    check(MatShift(K_.get(), by));
  }
  factor_is_current_ = false;
  is_regularized_ = true;
  ++statistics_.regularizations;
}

bool NewtonSolver::has_right_inertia() const {
  return !factor_failed_ &&
         negative_eigenvalues().value_or(equation_.num_negative_pivots()) == equation_.num_negative_pivots();
}

KSP NewtonSolver::linear_solver() const {
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_.get(), &ksp));
  return ksp;
}

void NewtonSolver::choose_krylov_method() {
  if (!may_choose_krylov_) return;
  set_krylov_method(linear_solver(), has_right_inertia() ? Symmetry::symmetric : Symmetry::indefinite);
}

bool NewtonSolver::factorize_definite(Vec q) {
  factorize(q);
  if (factor_failed_) return false;
  if (follows_) {
    choose_krylov_method();
    factor_is_wanted_ = !has_right_inertia();  // GMRES gains little from one of another matrix
    return true;
  }
  if (has_right_inertia()) return true;
  // A small shift of the diagonal keeps what is stiff, and leaves Newton's direction long where K is soft or unstable.
  // A merit of the residual knows no downhill: a direction that is long along an unstable mode gains nothing there.
  const bool may_shift = path_ == Path::minimisation || is_static_;
  const double mean = may_shift ? mean_diagonal() : 0.0;
  double total = 0.0;
  for (double part = std::max(least_shift, last_shift_ / 3.0); may_shift && part <= largest_shift;
       part *= shift_growth) {
    shift(part * mean - total);
    total = part * mean;
    factorize(q);
    if (lacks_memory_) return false;
    if (!has_right_inertia()) continue;
    last_shift_ = part;
    factor_is_wanted_ = true;  // the next Hessian may be definite again: look
    return true;
  }
  last_shift_ = 0.0;
  assemble(q, Projection::positive_semidefinite);
  factorize(q);
  factor_is_wanted_ = true;
  return !factor_failed_;
}

void NewtonSolver::factorize(Vec q) {
  const Stopwatch watch(statistics_.factorization_seconds);
  const SetUp outcome = set_up_preconditioner(preconditioner_.get(), K_.get());
  factor_failed_ = outcome != SetUp::sound;
  lacks_memory_ = outcome == SetUp::out_of_memory;
  statistics_.uses_multigrid_instead = uses_multigrid_instead(preconditioner_.get());
  if (rank_one_system_ && !factor_failed_) factor_failed_ = !rank_one_system_->set_up();
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_.get(), &ksp));
  check(KSPSetOperators(ksp, rank_one_system_ ? rank_one_system_->matrix() : K_.get(), K_.get()));
  if (rotations_) rotations_->start(equation_.displacements(q));
  ++statistics_.factorizations;
  factor_is_wanted_ = factor_failed_ || !may_keep_factor_;
  factor_is_current_ = true;
  excess_iterations_ = 0.0;
}

std::optional<PetscInt> NewtonSolver::negative_eigenvalues() const {
  std::optional<PetscInt> number = negative_pivots(preconditioner_.get());
  if (number && rank_one_system_) *number -= rank_one_system_->negative_eigenvalues();
  return number;
}

void NewtonSolver::linearize(Vec q) {
  assemble(q, Projection::none);
  if (adapts_tolerance_) {
    KSP ksp = nullptr;
    check(SNESGetKSP(snes_.get(), &ksp));
    PetscInt iteration = 0;
    PetscReal residual = 0.0;
    check(SNESGetIterationNumber(snes_.get(), &iteration));
    check(VecNorm(r_.get(), NORM_2, &residual));
    const double tolerance = takes_whole_steps_ ? tolerance_of_whole_steps
                                                : forcing_.tolerance(static_cast<int>(iteration), residual, target());
    check(KSPSetTolerances(ksp, tolerance, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  }
  if (path_ == Path::residual && !merit_has_scale_) {
    equation_.size_of_diagonal(K_.get(), trial_.get());
    merit_.set_scale(trial_.get());
    merit_has_scale_ = true;
  }
  if (!factor_is_wanted_) {
    if (rotations_) rotations_->follow(equation_.displacements(q));
    return;
  }
  factorize_definite(q);
  while (factor_failed_ && climb(q)) {
  }
  if (factor_failed_) check(SNESSetJacobianDomainError(snes_.get()));
}

void NewtonSolver::solve_linear(Vec r, Vec y) {
  const Stopwatch watch(statistics_.solve_seconds);
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_.get(), &ksp));
  check(KSPSolve(ksp, r, y));
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp, &iterations));
  statistics_.linear_iterations += iterations;
}

}  // namespace pliant
