// How far NewtonSolver goes along a direction, and where it turns when that does not help.
#include "solver/newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr double armijo = 1e-4;
constexpr double wolfe = 0.9;
/// Of the slope at the start of a line, with the sign turned: where the slope is larger, the step was too long.
constexpr double overshoot = 0.1;
constexpr int max_backtracks = 40;
/// Of a residual: a direction that does not help within 1e-6 of its length is not that of an approximation of K.
constexpr int max_residual_backtracks = 20;
/// Of the decrease that a linear equation promises. An approximation of K may thus converge linearly by a factor of
/// 0.9.
constexpr double required_part = 0.1;

/// What the last rung of the ladder adds to the diagonal, as a part of its mean: enough for a definite matrix where the
/// projected Hessian is singular.
constexpr double regularization = 1e-3;

/// Of the residual of a linear system that conjugate gradients may leave where they meet negative curvature.
constexpr double truncated_part = 0.1;

/// Iterations of the Krylov method that a factorization of the very matrix leaves at most, if it is sound.
constexpr PetscInt max_fresh_iterations = 40;

}  // namespace

bool NewtonSolver::linear_solver_broke_down(Vec r) const {
  KSP ksp = nullptr;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(SNESGetKSP(snes_.get(), &ksp));
  check(KSPGetConvergedReason(ksp, &reason));
  // Conjugate gradients that meet negative curvature leave what they had before it: a direction of descent, and a good
  // one if the linear system is nearly solved (truncated Newton: Nash 1984, "Newton-type minimization via the Lanczos
  // method").
  if (reason == KSP_DIVERGED_INDEFINITE_MAT) {
    PetscReal left = 0.0;
    check(KSPGetResidualNorm(ksp, &left));
    return left > truncated_part * norm(r);
  }
  if (reason == KSP_DIVERGED_ITS)
    return takes_whole_steps_ && !factor_is_current_;  // a poor direction, not a wrong one
  return reason < 0;
}

bool NewtonSolver::descends(Vec r, Vec y, double& slope) {
  KSP ksp = nullptr;
  check(SNESGetKSP(snes_.get(), &ksp));
  slope = -dot(r, y);
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp, &iterations));
  PetscReal tolerance = 0.0;
  check(KSPGetTolerances(ksp, &tolerance, nullptr, nullptr, nullptr));
  const double digits = -std::log10(tolerance);
  if (factor_is_current_) {
    fresh_rate_ = iterations / digits;
  } else {
    // What a kept factor has cost in iterations beyond those of a fresh one. When that makes a factorization, it was
    // time for one: never more than twice what foresight would have cost (as with skis, to be hired or bought).
    excess_iterations_ += std::max(0.0, iterations - (fresh_rate_ * digits + 1.0));
    if (excess_iterations_ > cost_of_set_up(preconditioner_.get())) factor_is_wanted_ = true;
  }
  if (linear_solver_broke_down(r) || !std::isfinite(slope)) return false;
  return path_ == Path::residual || slope < 0.0;  // whether a merit descends shows when it is tried
}

double NewtonSolver::first_length(Vec q, Vec d) {
  const double bound = inversion_margin * equation_.max_step(q, d);
  if (bound < 1.0) ++statistics_.capped_steps;
  return std::min(1.0, bound);
}

bool NewtonSolver::stops_at_rounding(SNESLineSearch search, double residual, double force_rounding) {
  at_rounding_floor_ = residual <= 100.0 * floor_factor * force_rounding;
  if (at_rounding_floor_) check(SNESLineSearchSetNorms(search, norm(solution_), residual, 0.0));
  return at_rounding_floor_;
}

void NewtonSolver::go_to(Vec trial, Vec q) {
  if (is_static_ || takes_whole_steps_) {
    check(VecCopy(q, before_.get()));
    equation_.extrapolate_from(before_.get());
  }
  check(VecCopy(trial, q));
}

bool NewtonSolver::lower_potential(Vec y, double slope, SNESLineSearch search) {
  Vec q = nullptr, r = nullptr, trial = nullptr;
  check(SNESLineSearchGetVecs(search, &q, &r, nullptr, &trial, nullptr));
  const double residual = norm(r), force_rounding = equation_.rounding_floor(q);
  check(VecWAXPY(trial_.get(), -1.0, start_, q));
  const double way = norm(trial_.get()), step = norm(y);
  check(VecScale(y, -1.0));  // the direction d
  double alpha = first_length(q, y);
  bool accepted = false, is_beyond = false;
  for (int i = 0; i < max_backtracks; ++i) {
    check(VecWAXPY(trial, alpha, y, q));
    const double phi = value(trial);
    // Rounding of Phi: that of the forces along the way from the stage's start, which is of first order where Phi
    // itself is of second; and a few units in the last place of Phi.
    const double noise = floor_factor * force_rounding * (way + alpha * step) +
                         1e3 * std::numeric_limits<double>::epsilon() * (std::abs(phi) + std::abs(phi_));
    const bool decreases = phi <= phi_ + armijo * alpha * slope;
    const bool undecided = !decreases && std::isfinite(phi) && std::abs(phi - phi_) <= noise;
    if (decreases || undecided) {
      check(SNESComputeFunction(snes_.get(), trial, r));
      const double after = norm(r), slope_after = dot(r, y);
      const bool wolfe_holds = slope_after >= wolfe * slope && slope_after <= (2 * armijo - 1) * slope;
      const bool is_too_long = decreases && slope_after > -overshoot * slope;
      is_beyond = is_beyond || is_too_long;
      if (went_beyond_ && is_too_long) {
        // Beyond the minimum along the line once more, as from one side of where friction changes its sign to the
        // other: so it would go on. The minimum of a parabola through the two slopes lies between.
        ++statistics_.backtracks;
        alpha *= slope / (slope - slope_after);
        continue;
      }
      accepted = std::isfinite(after) && (decreases || after < residual || wolfe_holds);
      if (accepted) {
        phi_ = phi;
        go_to(trial, q);
        check(SNESLineSearchSetLambda(search, alpha));
        took_full_step_ = alpha == 1.0;
        went_beyond_ = is_beyond;
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
  return stops_at_rounding(search, residual, force_rounding);
}

bool NewtonSolver::shortens_correction(Vec r, Vec d, double& alpha) {
  solve_linear(r, correction_.get());
  const bool is_usable = !linear_solver_broke_down(r);
  const double before = merit_.of_step(d), after = merit_.of_step(correction_.get());
  if (is_usable && after <= std::pow(1.0 - required_part * alpha, 2) * before) return true;
  // What a linear equation would leave is (1 - alpha) d; the rest grows with alpha^2, and this length leaves half the
  // promised decrease.
  check(VecAXPY(correction_.get(), 1.0 - alpha, d));
  const double rest = merit_.of_step(correction_.get());
  const double next = is_usable && rest > 0.0 ? 0.5 * alpha * alpha * std::sqrt(before / rest) : 0.0;
  alpha = std::clamp(next, 0.1 * alpha, 0.5 * alpha);
  return false;
}

bool NewtonSolver::lower_residual(Vec y, double slope, SNESLineSearch search) {
  Vec q = nullptr, r = nullptr, trial = nullptr;
  check(SNESLineSearchGetVecs(search, &q, &r, nullptr, &trial, nullptr));
  const double residual = norm(r), force_rounding = equation_.rounding_floor(q), step = norm(y);
  const double merit = merit_.of_residual(r);
  check(VecScale(y, -1.0));  // the direction d
  double alpha = first_length(q, y);
  bool accepted = false, is_beyond = false;
  for (int i = 0; i < max_residual_backtracks; ++i) {
    const double length = alpha;
    check(VecWAXPY(trial, length, y, q));
    check(SNESComputeFunction(snes_.get(), trial, trial_.get()));
    const double after = norm(trial_.get()), slope_after = dot(trial_.get(), y);
    // Forces of a potential or not, what is left of them along the direction shows where it was followed too far.
    const bool is_too_long = slope < 0.0 && slope_after > -overshoot * slope;
    is_beyond = is_beyond || is_too_long;
    if (went_beyond_ && is_too_long) {
      ++statistics_.backtracks;
      alpha *= slope / (slope - slope_after);
      continue;
    }
    const bool falls = merit_.of_residual(trial_.get()) <= std::pow(1.0 - required_part * length, 2) * merit;
    const bool is_finite = std::isfinite(after) && (!follows_ || std::isfinite(value(trial)));
    accepted = is_finite && (takes_whole_steps_ || falls || after <= floor_factor * force_rounding);
    if (!accepted && is_finite) {
      accepted = shortens_correction(trial_.get(), y, alpha);
    } else {
      alpha *= 0.5;
    }
    if (accepted) {
      check(VecCopy(trial_.get(), r));
      go_to(trial, q);
      check(SNESLineSearchSetLambda(search, length));
      took_full_step_ = length == 1.0;
      went_beyond_ = is_beyond;
      check(SNESLineSearchSetNorms(search, norm(q), after, length * step));
      break;
    }
    ++statistics_.backtracks;
  }
  check(VecScale(y, -1.0));
  return accepted || stops_at_rounding(search, residual, force_rounding);
}

bool NewtonSolver::factor_is_poor() const {
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(linear_solver(), &iterations));
  return factor_is_current_ && iterations > max_fresh_iterations;
}

bool NewtonSolver::climb(Vec q) {
  if (lacks_memory_) return false;  // another matrix takes as much
  if (!factor_is_current_) {
    // On the residual Newton's own direction is the best, whatever the signs of the eigenvalues.
    path_ == Path::residual && !is_static_ ? factorize(q) : static_cast<void>(factorize_definite(q));
    return true;
  }
  if (follows_) return false;
  if (projection_ == Projection::none) {
    assemble(q, Projection::positive_semidefinite);
  } else if (!is_regularized_) {
    shift(regularization * mean_diagonal());
  } else {
    return false;
  }
  factorize(q);
  factor_is_wanted_ = true;  // the next Hessian may do without
  return true;
}

void NewtonSolver::search_line(SNESLineSearch search) {
  Vec q = nullptr, r = nullptr, y = nullptr;
  has_direction_ = true;
  check(SNESLineSearchGetVecs(search, &q, &r, &y, nullptr, nullptr));
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  for (;;) {
    while (factor_is_poor() && refine_factorization(preconditioner_.get())) {
      if (!factorize_definite(q)) break;
      solve_linear(r, y);
    }
    double slope = 0.0;
    if (descends(r, y, slope)) {
      if (path_ == Path::minimisation ? lower_potential(y, slope, search) : lower_residual(y, slope, search)) return;
    }
    bool has_factor = false;
    while (!has_factor && climb(q)) has_factor = !factor_failed_;
    if (!has_factor) break;
    solve_linear(r, y);
  }
  check(SNESLineSearchSetReason(search, SNES_LINESEARCH_FAILED_REDUCT));
}

}  // namespace pliant
