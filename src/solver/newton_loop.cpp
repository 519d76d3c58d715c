#include "solver/newton_loop.hpp"

#include "base/stopwatch.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Iterations that have reduced the residual below this fraction of the first one are converging.
constexpr double nearly_converged = 1e-3;
/// Iterations that end at a wall are not counted, but there are no more than this multiple of the limit in all. They
/// find one by one what the bodies meet on their way, and lose less than the shorter steps that would follow.
constexpr int most_per_counted = 4;
/// Iterations that go less than this part of the way to a wall do not end at it.
constexpr double part_to_wall = 0.5;
/// Where the residual falls below this fraction in an iteration, the exact Hessian is likely to be definite next.
constexpr double fast_fall = 0.5;
/// After so many iterations with projected barriers from the start the residual no longer falls: negative curvature may
/// lead on.
constexpr int most_projecting = 3;
/// A step with the Hessian of the iterate before leaves twice the part of the residual that the last step has left, as
/// far as the Hessian changes linearly; this is the margin on it.
constexpr double margin_of_kept_hessian = 5.0;
/// Relative tolerance of linear systems whose solutions are taken as whole steps: with errors in stiff directions, a
/// step along soft ones would cause large forces.
constexpr double tolerance_of_whole_steps = 1e-8;

std::string in_words(SNESConvergedReason reason) {
  switch (reason) {
    case SNES_DIVERGED_FNORM_NAN:
      return "the residual is not a number";
    case SNES_DIVERGED_MAX_IT:
      return "Newton's method ran out of iterations";
    case SNES_DIVERGED_LINE_SEARCH:
      return "the line search found no step length that lowers the potential (or the residual, if there is none)";
    case SNES_DIVERGED_JACOBIAN_DOMAIN:
      return "the Hessian (tangent stiffness) is singular, even with a shifted diagonal";
    case SNES_DIVERGED_LINEAR_SOLVE:
      return "the linear solver failed";
    default:
      return fmt::format("Newton's method stopped ({})", SNESConvergedReasons[reason]);
  }
}

KSP linear_solver_of(SNES snes) {
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  return ksp;
}

}  // namespace

// The loop.

StageReport NewtonLoop::run(Vec q) {
  const double before = statistics_.factorization_seconds + statistics_.assembly_seconds + statistics_.solve_seconds;
  double total = 0.0;
  is_at_rounding_ = has_old_hessian_ = false;
  num_at_wall_ = num_projecting_ = 0;
  line_search_.begin();
  {
    const Stopwatch watch(total);
    // PETSc 3.18 never clears the error of an earlier solve, so that it counts only where it is set.
    check(SNESSetCheckJacobianDomainError(snes_.get(), PETSC_FALSE));
    guard_.rethrow(SNESSolve(snes_.get(), nullptr, q));
  }
  const double accounted =
      statistics_.factorization_seconds + statistics_.assembly_seconds + statistics_.solve_seconds - before;
  statistics_.solve_seconds += std::max(0.0, total - accounted);  // the solves SNES does itself

  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  check(SNESGetConvergedReason(snes_.get(), &reason));
  if (reason == SNES_DIVERGED_LINE_SEARCH && convergence_.has_met_first_target()) {
    reason = SNES_CONVERGED_FNORM_ABS;
    convergence_.count_rounding(log_.iterations().back().residual, q);
  }
  // What is not a number in a factor stays there.
  if (reason == SNES_DIVERGED_LINEAR_SOLVE || reason == SNES_DIVERGED_JACOBIAN_DOMAIN) system_.factor().renew();
  if (objective_.aim() == Aim::any_equilibrium) system_.use_usual_krylov_method();
  return report_of(reason);
}

void NewtonLoop::linearize(Vec q) {
  using enum LinearSystem::Remedy;
  const bool hovers = num_projecting_ >= most_projecting;
  const bool projects = goes_on_projecting() && !hovers;
  const bool descends = objective_.aim() == Aim::descent;
  has_old_hessian_ = !has_old_hessian_ && !projects && keeps_hessian();
  if (has_old_hessian_) {
    num_projecting_ = 0;
    set_tolerance();
    (void)system_.prepare(q);
    return;
  }
  if (!projects) system_.assemble(q, descends ? Projection::positive_semidefinite : Projection::none);
  if (adapts_tolerance_) set_tolerance();
  objective_.scale_merit(system_.sparse_matrix());
  const bool is_prepared = projects ? system_.prepare_with_projected_walls(q)
                                    : system_.prepare(q, hovers ? shifted_diagonal : projected_walls);
  num_projecting_ = projects ? num_projecting_ + 1 : 0;
  if (is_prepared) return;
  check(SNESSetJacobianDomainError(snes_.get()));
  check(SNESSetCheckJacobianDomainError(snes_.get(), PETSC_TRUE));
}

// With the error e of an iterate, Newton's step leaves K'(e, e)/2, and a step with the Hessian of the iterate before
// K'(e, e'), e' the next error (Ortega & Rheinboldt 1970, 10.2: the chord method).
bool NewtonLoop::keeps_hessian() const {
  const auto& iterations = log_.iterations();
  const Escalation& escalation = system_.escalation();
  const bool is_exact = !escalation.is_projected() && !escalation.is_shifted();
  const bool may = adapts_tolerance_ && !equation_.is_static() && !system_.factor().wants_factor() &&
                   (objective_.aim() == Aim::minimum || objective_.aim() == Aim::root);
  if (!may || !is_exact || iterations.size() < 2 || last_length_ != 1.0) return false;
  const double before = iterations[iterations.size() - 2].residual, now = iterations.back().residual;
  return 2.0 * margin_of_kept_hessian * now * now <= before * convergence_.target();
}

bool NewtonLoop::goes_on_projecting() const {
  const auto& iterations = log_.iterations();
  if (!system_.projects_walls() || !objective_.is_minimised() || iterations.size() < 2) return false;
  const double before = iterations[iterations.size() - 2].residual;
  return iterations.back().residual > fast_fall * before;
}

void NewtonLoop::search(SNESLineSearch search) {
  Vec q = nullptr, r = nullptr, y = nullptr;
  check(SNESLineSearchGetVecs(search, &q, &r, &y, nullptr, nullptr));
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  has_direction_ = true;
  for (;;) {
    system_.improve_poor_factor(q, r, y);
    system_.note_solve();
    if (system_.has_direction(r) && go_along(q, r, y, search)) return;
    if (has_old_hessian_) {
      has_old_hessian_ = false;
      system_.assemble(q);
      if (system_.prepare(q)) system_.solve(r, y);
      continue;
    }
    if (!system_.escalate(q)) break;
    system_.solve(r, y);
  }
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_FAILED_REDUCT));
}

bool NewtonLoop::go_along(Vec q, Vec r, Vec y, SNESLineSearch search) {
  const double slope = -dot(r, y);
  // Whether a merit decreases along the direction is found by trying.
  const bool descends = objective_.is_minimised() || objective_.aim() == Aim::descent;
  if (!std::isfinite(slope) || (descends && slope >= 0.0)) return false;
  Vec trial = nullptr;
  check(SNESLineSearchGetVecs(search, nullptr, nullptr, nullptr, &trial, nullptr));
  const LineStart start = line_.lay(q, r, y, trial, value_);
  const auto demand = objective_.aim() == Aim::whole_steps ? LineSearch::Demand::none
                      : objective_.aim() == Aim::descent   ? LineSearch::Demand::descent
                                                           : LineSearch::Demand::decrease;
  const LineOutcome outcome = objective_.is_minimised() ? line_search_.lower_potential(line_, start)
                                                        : line_search_.lower_residual(line_, start, demand);
  statistics_.backtracks += outcome.backtracks;
  is_at_rounding_ = outcome.status == LineOutcome::Status::at_rounding;
  switch (outcome.status) {
    case LineOutcome::Status::accepted:
      line_.take(q, r);
      if (objective_.is_minimised()) value_ = outcome.potential;
      last_length_ = outcome.length;
      if (start.is_at_wall && outcome.length > part_to_wall * start.first_length) ++num_at_wall_;
      check(SNESLineSearchSetLambda(search, outcome.length));
      check(SNESLineSearchSetNorms(search, norm(q), outcome.residual, outcome.length * start.step));
      return true;
    case LineOutcome::Status::at_rounding:
      check(SNESLineSearchSetNorms(search, norm(q), start.residual, 0.0));
      return true;
    case LineOutcome::Status::stalled:
      return false;
  }
  return false;
}

SNESConvergedReason NewtonLoop::judge(int iteration, double residual) {
  note_iteration(iteration, residual);
  if (std::isfinite(residual) && iteration > 0 && objective_.aim() != Aim::whole_steps) {
    last_length_ == 1.0 ? forcing_.observe(residual) : forcing_.forget();
  }
  Vec q = nullptr;
  check(SNESGetSolution(snes_.get(), &q));
  switch (convergence_.judge(iteration, residual, q, is_at_rounding_)) {
    case Convergence::Verdict::not_a_number:
      return SNES_DIVERGED_FNORM_NAN;
    case Convergence::Verdict::converged:
      return SNES_CONVERGED_FNORM_RELATIVE;
    case Convergence::Verdict::at_rounding:
      return SNES_CONVERGED_FNORM_ABS;
    case Convergence::Verdict::iterating:
      break;
  }
  // Where bodies have rotated by much, the search continues with other unknowns (NewtonSolver::solve).
  const bool goes_on = iteration - num_at_wall_ < limit_ && !(iteration > 0 && equation_.is_far_from_guess(q));
  return goes_on ? SNES_CONVERGED_ITERATING : SNES_DIVERGED_MAX_IT;
}

void NewtonLoop::limit_iterations(int number) {
  limit_ = number;
  // No tolerance on the step: after a failed line search SNES would compare it with the lengths of an earlier step.
  check(SNESSetTolerances(snes_.get(), PETSC_DEFAULT, PETSC_DEFAULT, 0.0, most_per_counted * number, PETSC_MAX_INT));
}

// What begins and ends a run.

void NewtonLoop::begin_stage() {
  has_direction_ = false;
  system_.factor().begin_stage();
  convergence_.begin_stage();
  log_.begin_stage();
}

void NewtonLoop::use_guess(Vec q, double measure) {
  value_ = measure;
  convergence_.measure_guess(q);
}

void NewtonLoop::resume(Vec q) {
  if (objective_.is_minimised()) value_ = objective_.value(q);
  convergence_.expect_solution();
}

void NewtonLoop::begin(Vec q, Aim aim) {
  equation_.extrapolate_from(nullptr);
  objective_.set_aim(aim);
  objective_.forget_scale_of_merit();
  if (objective_.is_minimised()) value_ = objective_.value(q);
  convergence_.measure(q);
}

void NewtonLoop::begin_again(Vec q) {
  equation_.extrapolate_from(nullptr);
  if (objective_.is_minimised()) value_ = objective_.value(q);
  convergence_.use_scale_of_guess();
}

StageReport NewtonLoop::run(Vec q, int max_iterations) {
  limit_iterations(max_iterations);
  StageReport report = run(q);
  limit_iterations(options_.max_iterations);
  return report;
}

bool NewtonLoop::is_converging() const {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  check(SNESGetConvergedReason(snes_.get(), &reason));
  const auto& iterations = log_.iterations();
  return reason == SNES_DIVERGED_MAX_IT && iterations.back().residual < nearly_converged * iterations.front().residual;
}

double NewtonLoop::stiffness(Vec q) {
  system_.assemble(q);
  return system_.mean_diagonal();
}

void NewtonLoop::forget() {
  objective_.equation().forget();
  objective_.forget();
  forcing_.forget();
  system_.forget();
}

KSP NewtonLoop::linear_solver() const {
  return linear_solver_of(snes_.get());
}

Vec NewtonLoop::last_direction() const {
  if (!has_direction_) return nullptr;
  Vec y = nullptr;
  check(SNESGetSolutionUpdate(snes_.get(), &y));
  return y;
}

StageReport NewtonLoop::report_of(SNESConvergedReason reason) const {
  PetscInt newton = 0, linear = 0;
  check(SNESGetIterationNumber(snes_.get(), &newton));
  check(SNESGetLinearSolveIterations(snes_.get(), &linear));
  statistics_.newton_iterations += newton;
  statistics_.linear_iterations += linear;
  StageReport report;
  report.newton_iterations = static_cast<int>(newton);
  report.linear_iterations = static_cast<int>(linear);
  if (reason > 0) {
    report.reason = reason == SNES_CONVERGED_FNORM_ABS ? "converged to the rounding errors of the forces" : "converged";
    return report;
  }
  report.outcome = StageOutcome::retry;
  report.reason = in_words(reason);
  if (system_.factor().lacks_memory()) {
    // A shorter step needs as much memory.
    report.outcome = StageOutcome::fatal;
    report.reason = "there is too little memory for the factorization (MUMPS)";
  }
  return report;
}

void NewtonLoop::note_iteration(int iteration, double residual) {
  NewtonIteration now;
  now.residual = residual;
  if (iteration > 0) {
    SNESLineSearch search = nullptr;
    PetscInt linear_iterations = 0;
    check(SNESGetLineSearch(snes_.get(), &search));
    check(SNESLineSearchGetLambda(search, &now.step_length));
    check(KSPGetIterationNumber(linear_solver_of(snes_.get()), &linear_iterations));
    now.linear_iterations = static_cast<int>(linear_iterations);
    if (system_.escalation().is_projected()) now.hessian = NewtonIteration::Hessian::projected;
    if (system_.escalation().is_shifted()) now.hessian = NewtonIteration::Hessian::shifted;
  }
  log_.note(now, convergence_.target(), iteration == 0);
}

void NewtonLoop::set_tolerance() {
  PetscInt iteration = 0;
  check(SNESGetIterationNumber(snes_.get(), &iteration));
  const double tolerance = objective_.aim() == Aim::whole_steps
                               ? tolerance_of_whole_steps
                               : forcing_.tolerance(static_cast<int>(iteration), norm(r_.get()), convergence_.target());
  check(KSPSetTolerances(linear_solver_of(snes_.get()), tolerance, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
}

// SNES.

NewtonLoop::NewtonLoop(Objective& objective, const NewtonOptions& options, LinearKind linear,
                       SolverStatistics& statistics)
    : objective_(objective),
      equation_(objective.equation()),
      options_(options),
      statistics_(statistics),
      r_(equation_.make_vector()),
      K_(equation_.make_hessian()),
      snes_(make_snes(K_.get(), options, linear)),
      system_(objective, linear_solver_of(snes_.get()), std::move(K_), statistics),
      line_(objective, system_, snes_.get(), statistics),
      convergence_(objective, options, statistics, [this](Vec q) { system_.assemble(q); }) {
  if (system_.matrix() != system_.sparse_matrix()) {
    check(SNESSetJacobian(snes_.get(), system_.matrix(), system_.sparse_matrix(), hessian_callback, this));
  }
  PetscInt given = 0;
  check(SNESGetTolerances(snes_.get(), nullptr, nullptr, nullptr, &given, nullptr));
  limit_iterations(static_cast<int>(given));
  PetscBool tolerance_is_given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, "-ksp_rtol", &tolerance_is_given));
  adapts_tolerance_ = !tolerance_is_given;
}

Handle<SNES> NewtonLoop::make_snes(Mat K, const NewtonOptions& options, LinearKind linear) {
  Handle<SNES> made;
  check(SNESCreate(equation_.comm(), made.out()));
  SNES snes = made.get();
  check(SNESSetType(snes, SNESNEWTONLS));
  check(SNESSetFunction(snes, r_.get(), residual_callback, this));
  check(SNESSetJacobian(snes, K, K, hessian_callback, this));
  check(SNESSetConvergenceTest(snes, convergence_callback, this, nullptr));
  check(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, 0.0, options.max_iterations, PETSC_MAX_INT));
  // Only LinearSystem sets up preconditioners.
  check(SNESSetLagPreconditioner(snes, -1));
  // The line search handles a failed linear solve: it escalates.
  check(SNESSetMaxLinearSolveFailures(snes, PETSC_MAX_INT));
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  check(SNESLineSearchShellSetUserFunc(search, line_search_callback, this));
  const bool has_levels = linear == LinearKind::p_multigrid || linear == LinearKind::adaptive;
  const auto coarsening = has_levels ? equation_.make_coarsening() : std::nullopt;
  configure_linear_solver(linear_solver_of(snes), K, linear, equation_.symmetry(), coarsening ? &*coarsening : nullptr);
  check(SNESSetFromOptions(snes));
  return made;
}

PetscErrorCode NewtonLoop::residual_callback(SNES, Vec q, Vec r, void* self) {
  auto* loop = static_cast<NewtonLoop*>(self);
  return loop->guard_.run([&] { loop->objective_.gradient(q, r); });
}

PetscErrorCode NewtonLoop::hessian_callback(SNES, Vec q, Mat, Mat, void* self) {
  auto* loop = static_cast<NewtonLoop*>(self);
  return loop->guard_.run([&] { loop->linearize(q); });
}

PetscErrorCode NewtonLoop::line_search_callback(SNESLineSearch search, void* self) {
  auto* loop = static_cast<NewtonLoop*>(self);
  return loop->guard_.run([&] { loop->search(search); });
}

PetscErrorCode NewtonLoop::convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                                SNESConvergedReason* reason, void* self) {
  auto* loop = static_cast<NewtonLoop*>(self);
  return loop->guard_.run([&] { *reason = loop->judge(static_cast<int>(it), f); });
}

}  // namespace pliant
