#include "solver/newton.hpp"

#include "base/stopwatch.hpp"
#include "petsc/array_view.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double armijo = 1e-4;
constexpr double wolfe = 0.9;
constexpr double inversion_margin = 0.9;  // of the step at which a tetrahedron becomes flat
constexpr int max_backtracks = 40;
/// What the last rung of the ladder adds to the diagonal, as a part of its mean: enough for a definite matrix where the
/// projected Hessian is singular.
constexpr double regularization = 1e-3;
/// Conjugate gradients that need so many iterations more than with a fresh factor have it renewed for the next Hessian.
/// A factorization costs some 10 (few unknowns) to 25 (many) iterations, a set-up of multigrid about as many.
constexpr PetscInt iterations_that_age = 8;
/// The residual's rounding floor is an estimate: below this multiple of it nothing is to be gained.
constexpr double floor_factor = 4.0;

std::string in_words(SNESConvergedReason reason) {
  switch (reason) {
    case SNES_DIVERGED_FNORM_NAN:
      return "the residual is not a number";
    case SNES_DIVERGED_MAX_IT:
      return "Newton's method ran out of iterations";
    case SNES_DIVERGED_LINE_SEARCH:
      return "no step length lowers the potential";
    case SNES_DIVERGED_LINEAR_SOLVE:
      return "the linear solver failed";
    default:
      return fmt::format("Newton's method stopped ({})", SNESConvergedReasons[reason]);
  }
}

double dot(Vec a, Vec b) {
  PetscScalar result = 0.0;
  check(VecDot(a, b, &result));
  return result;
}

double norm(Vec a) {
  PetscReal result = 0.0;
  check(VecNorm(a, NORM_2, &result));
  return result;
}

}  // namespace

NewtonSolver::NewtonSolver(StageEquation& potential, const NewtonOptions& options, LinearKind linear)
    : potential_(potential),
      options_(options),
      K_(potential.make_hessian()),
      r_(potential.make_vector()),
      trial_(potential.make_vector()) {
  SNES snes = nullptr;
  check(SNESCreate(potential.comm(), snes_.out()));
  snes = snes_.get();
  check(SNESSetType(snes, SNESNEWTONLS));
  check(SNESSetFunction(snes, r_.get(), residual_callback, this));
  check(SNESSetJacobian(snes, K_.get(), K_.get(), hessian_callback, this));
  check(SNESSetConvergenceTest(snes, convergence_callback, this, nullptr));
  // No tolerance on the step: SNES would compare it after a failed line search too, with the lengths of an earlier
  // step.
  check(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, 0.0, options.max_iterations, PETSC_MAX_INT));
  // Preconditioners are set up in `factorize`, nowhere else.
  check(SNESSetLagPreconditioner(snes, -1));
  // A failed linear solve is the line search's business: it climbs the ladder.
  check(SNESSetMaxLinearSolveFailures(snes, PETSC_MAX_INT));
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes, &search));
  check(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  check(SNESLineSearchShellSetUserFunc(search, line_search_callback, this));
  KSP ksp = nullptr;
  check(SNESGetKSP(snes, &ksp));
  configure_linear_solver(ksp, K_.get(), linear);
  check(SNESSetFromOptions(snes));
  PetscBool solves_directly = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &solves_directly));
  may_keep_factor_ = !solves_directly;
}

PetscErrorCode NewtonSolver::residual_callback(SNES, Vec q, Vec r, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] {
    const Stopwatch watch(solver->statistics_.assembly_seconds);
    solver->potential_.gradient(q, r);
  });
}

PetscErrorCode NewtonSolver::hessian_callback(SNES, Vec q, Mat, Mat, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] { solver->linearize(q); });
}

PetscErrorCode NewtonSolver::line_search_callback(SNESLineSearch search, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] { solver->search_line(search); });
}

PetscErrorCode NewtonSolver::convergence_callback(SNES, PetscInt it, PetscReal, PetscReal, PetscReal f,
                                                  SNESConvergedReason* reason, void* self) {
  auto* solver = static_cast<NewtonSolver*>(self);
  return solver->guard_.run([&] { *reason = solver->judge(it, f); });
}

double NewtonSolver::value(Vec q) {
  const Stopwatch watch(statistics_.assembly_seconds);
  return potential_.value(q);
}

void NewtonSolver::choose_guess(const StagePoint& stage, Vec q) {
  // Prescribed entries of q stand at their values; the others may go where inertia alone would lead.
  phi_ = value(q);
  check(VecCopy(q, trial_.get()));
  {
    const ArrayView guess(trial_.get());
    const ConstArrayView q0(stage.q0), v0(stage.v0);
    const auto& prescribed = potential_.prescribed();
    for (std::size_t i = 0; i < q0.span().size(); ++i) {
      const auto k = static_cast<PetscInt>(i);
      if (!prescribed[i]) guess[k] = q0[k] + stage.dt * v0[k];
    }
  }
  const double phi = value(trial_.get());
  if (phi < phi_) {
    phi_ = phi;
    check(VecCopy(trial_.get(), q));
  }
}

void NewtonSolver::assemble(Vec q, Projection projection) {
  {
    const Stopwatch watch(statistics_.assembly_seconds);
    potential_.hessian(q, K_.get(), projection);
  }
  factor_is_current_ = false;
  if (projection != Projection::none) ++statistics_.projections;
  projection_ = projection;
  is_regularized_ = false;
}

void NewtonSolver::regularize() {
  check(MatGetDiagonal(K_.get(), trial_.get()));
  PetscReal total = 0.0;
  check(VecNorm(trial_.get(), NORM_1, &total));
  check(MatShift(K_.get(), regularization * total / potential_.num_unknowns()));
  factor_is_current_ = false;
  is_regularized_ = true;
  ++statistics_.regularizations;
}

void NewtonSolver::factorize() {
  const Stopwatch watch(statistics_.factorization_seconds);
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_.get(), &ksp));
  check(KSPSetReusePreconditioner(ksp, PETSC_FALSE));
  check(KSPSetOperators(ksp, K_.get(), K_.get()));
  check(KSPSetUp(ksp));
  check(KSPSetReusePreconditioner(ksp, PETSC_TRUE));
  ++statistics_.factorizations;
  factor_is_wanted_ = !may_keep_factor_;
  factor_is_current_ = true;
}

void NewtonSolver::linearize(Vec q) {
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_.get(), &ksp));
  assemble(q, Projection::none);
  if (!factor_is_wanted_) return;
  factorize();
  if (negative_pivots(ksp) > 0) {
    assemble(q, Projection::positive_semidefinite);
    factorize();
    factor_is_wanted_ = true;  // the next Hessian may be definite again: look
  }
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

bool NewtonSolver::descends(Vec r, Vec y, double& slope) {
  KSP ksp = nullptr;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(SNESGetKSP(snes_.get(), &ksp));
  check(KSPGetConvergedReason(ksp, &reason));
  slope = -dot(r, y);
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp, &iterations));
  if (factor_is_current_) {
    fresh_iterations_ = iterations;
  } else if (iterations > fresh_iterations_ + iterations_that_age) {
    factor_is_wanted_ = true;
  }
  // Out of iterations is a poor direction, not a wrong one.
  return (reason >= 0 || reason == KSP_DIVERGED_ITS) && slope < 0.0 && std::isfinite(slope);
}

bool NewtonSolver::step_along(Vec y, double slope, SNESLineSearch search) {
  Vec q = nullptr, r = nullptr, trial = nullptr;
  check(SNESLineSearchGetVecs(search, &q, &r, nullptr, &trial, nullptr));
  const double residual = norm(r), force_rounding = potential_.rounding_floor(q);
  check(VecWAXPY(trial_.get(), -1.0, start_, q));
  const double way = norm(trial_.get()), step = norm(y);
  check(VecScale(y, -1.0));  // the direction d
  const double bound = inversion_margin * potential_.max_step(q, y);
  if (bound < 1.0) ++statistics_.capped_steps;
  double alpha = std::min(1.0, bound);
  bool accepted = false;
  for (int i = 0; i < max_backtracks; ++i) {
    check(VecWAXPY(trial, alpha, y, q));
    const double phi = value(trial);
    // Rounding of Phi: that of the forces along the way from the stage's start, which is of first order where Phi
    // itself is of second; and a few units in the last place of Phi.
    const double noise = floor_factor * force_rounding * (way + alpha * step) +
                         1e3 * std::numeric_limits<double>::epsilon() * (std::abs(phi) + std::abs(phi_));
    const bool decreases = potential_.is_potential() && phi <= phi_ + armijo * alpha * slope;
    const bool undecided = !decreases && std::isfinite(phi) && std::abs(phi - phi_) <= noise;
    if (decreases || undecided) {
      check(SNESComputeFunction(snes_.get(), trial, r));
      const double after = norm(r), slope_after = dot(r, y);
      const bool wolfe_holds = slope_after >= wolfe * slope && slope_after <= (2 * armijo - 1) * slope;
      accepted = std::isfinite(after) && (decreases || after < residual || wolfe_holds);
      if (accepted) {
        phi_ = phi;
        check(VecCopy(trial, q));
        check(SNESLineSearchSetLambda(search, alpha));
        check(SNESLineSearchSetNorms(search, norm(q), after, alpha * step));
        break;
      }
    }
    ++statistics_.backtracks;
    // Minimum of the parabola through Phi(0), its slope and Phi(alpha), kept within a tenth and a half.
    const double parabola = std::isfinite(phi) ? -slope * alpha / (2.0 * ((phi - phi_) / alpha - slope)) : 0.5 * alpha;
    alpha = std::clamp(parabola, 0.1 * alpha, 0.5 * alpha);
  }
  check(VecScale(y, -1.0));
  if (accepted) return true;
  check(SNESComputeFunction(snes_.get(), q, r));
  // Nothing lowers Phi any more; if the residual is as small as its rounding errors, this is the minimum.
  at_rounding_floor_ = residual <= 100.0 * floor_factor * force_rounding;
  if (at_rounding_floor_) check(SNESLineSearchSetNorms(search, norm(q), residual, 0.0));
  return at_rounding_floor_;
}

bool NewtonSolver::climb(Vec q) {
  if (!factor_is_current_) {
    factorize();
    return true;
  }
  if (projection_ == Projection::none) {
    assemble(q, Projection::positive_semidefinite);
  } else if (!is_regularized_) {
    regularize();
  } else {
    return false;
  }
  factorize();
  factor_is_wanted_ = true;  // the next Hessian may do without
  return true;
}

void NewtonSolver::search_line(SNESLineSearch search) {
  Vec q = nullptr, r = nullptr, y = nullptr;
  check(SNESLineSearchGetVecs(search, &q, &r, &y, nullptr, nullptr));
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  for (;;) {
    double slope = 0.0;
    if (descends(r, y, slope) && step_along(y, slope, search)) return;
    if (!climb(q)) break;
    solve_linear(r, y);
  }
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_FAILED_REDUCT));
}

SNESConvergedReason NewtonSolver::judge(PetscInt iteration, double residual) {
  if (!std::isfinite(residual)) return SNES_DIVERGED_FNORM_NAN;
  if (residual <= std::max(options_.relative * scale_, options_.absolute)) return SNES_CONVERGED_FNORM_RELATIVE;
  if (at_rounding_floor_ || (iteration > 0 && residual <= floor_factor * potential_.rounding_floor(solution_))) {
    ++statistics_.rounding_stops;
    return SNES_CONVERGED_FNORM_ABS;
  }
  return SNES_CONVERGED_ITERATING;
}

StageReport NewtonSolver::solve(const StagePoint& stage, Vec q) {
  ++statistics_.stages;
  potential_.begin_stage(stage);
  at_rounding_floor_ = false;
  start_ = stage.q0;
  solution_ = q;
  choose_guess(stage, q);
  StageReport report;
  if (!std::isfinite(phi_)) {
    report.outcome = StageOutcome::retry;
    report.reason = "the prescribed motion turns a tetrahedron inside out within one step";
    return report;
  }
  scale_ = potential_.force_scale(q);

  const double before = statistics_.factorization_seconds + statistics_.assembly_seconds + statistics_.solve_seconds;
  double total = 0.0;
  {
    const Stopwatch watch(total);
    guard_.rethrow(SNESSolve(snes_.get(), nullptr, q));
  }
  const double accounted =
      statistics_.factorization_seconds + statistics_.assembly_seconds + statistics_.solve_seconds - before;
  statistics_.solve_seconds += std::max(0.0, total - accounted);  // the solves SNES does itself

  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  check(SNESGetConvergedReason(snes_.get(), &reason));
  check(SNESGetIterationNumber(snes_.get(), &newton));
  check(SNESGetLinearSolveIterations(snes_.get(), &linear));
  statistics_.newton_iterations += newton;
  statistics_.linear_iterations += linear;
  report.newton_iterations = static_cast<int>(newton);
  report.linear_iterations = static_cast<int>(linear);
  if (reason > 0) {
    report.reason = reason == SNES_CONVERGED_FNORM_ABS ? "converged to the rounding of the forces" : "converged";
  } else {
    report.outcome = StageOutcome::retry;
    report.reason = in_words(reason);
  }
  return report;
}

}  // namespace pliant
