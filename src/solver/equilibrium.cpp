// How NewtonSolver finds an equilibrium where there is no inertia.
#include "solver/newton.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Iterations on the way to an equilibrium nearby: Newton's method squares the error.
constexpr int max_followed = 8;
/// What a stage without an equilibrium adds to the trouble of which others take one away, and how much there is when a
/// body is allowed to snap far away: shorter steps may find an equilibrium nearby.
constexpr int trouble_of_failure = 2, trouble_before_snap = 4;
/// How many times as many iterations as others a body may take that snaps.
constexpr int times_to_snap = 20;
/// Weights that hold the solutions of a descent, as parts of the Hessian's mean diagonal.
constexpr double first_weight = 1e-3, least_weight = 1e-9;
/// Such a solution may leave this part of the residual of the one before,
constexpr double part_left = 0.1;
/// and takes so many iterations at most; from half as many on, the weight stays.
constexpr int iterations_of_descent = 8;

}  // namespace

StageReport NewtonSolver::seek_equilibrium(Vec q) {
  const Handle<Vec> best = equation_.make_vector(), lowest = equation_.make_vector();
  check(VecCopy(q, best.get()));
  check(VecCopy(q, lowest.get()));
  const Path usual = path_;
  StageReport report;
  int newton = 0, linear = 0;
  // Whether nothing more needs to be tried.
  const auto attempt = [&](bool follows, Vec guess, int max_iterations) {
    if (max_iterations <= 0) return false;
    check(VecCopy(guess, q));
    equation_.extrapolate_from(nullptr);
    follows_ = follows;
    if (follows) path_ = Path::residual;
    if (path_ == Path::minimisation) phi_ = value(q);
    factor_is_wanted_ = factor_is_wanted_ || newton > 0;
    merit_has_scale_ = at_rounding_floor_ = false;
    scale_ = equation_.force_scale(q);
    limit_iterations(max_iterations);
    const int end = newton + std::max(max_iterations, options_.max_iterations);
    do {
      report = iterate(q);
      newton += report.newton_iterations;
      linear += report.linear_iterations;
    } while (report.outcome == StageOutcome::retry && newton < end && is_converging());
    if (report.outcome == StageOutcome::converged) {
      prefers_following_ = follows && !has_right_inertia();
      if (prefers_following_) ++statistics_.unstable_stages;
    }
    path_ = usual;
    follows_ = false;
    if (may_choose_krylov_) set_krylov_method(linear_solver(), Symmetry::symmetric);
    return report.outcome != StageOutcome::retry;
  };
  const auto few = [&] { return std::min(max_followed, options_.max_iterations - newton); };
  const auto minimise = [&] {
    const bool arrives = attempt(false, best.get(), few());
    check(VecCopy(q, lowest.get()));
    return arrives;
  };
  const auto follow = [&] {
    return attempt(true, best.get(), few()) || (has_second_guess_ && attempt(true, guess_.get(), few()));
  };
  const bool arrives = prefers_following_ ? follow() || minimise() : minimise() || follow();
  if (!arrives && trouble_ >= trouble_before_snap && options_.max_iterations > 3 * max_followed) {
    trouble_ = 0;  // if this does not help, shorter steps may
    check(VecCopy(lowest.get(), q));
    const StageReport way = descend(q, times_to_snap * options_.max_iterations);
    newton += way.newton_iterations;
    linear += way.linear_iterations;
    check(VecCopy(q, lowest.get()));
    attempt(false, lowest.get(), options_.max_iterations);
  } else if (!arrives) {
    attempt(false, lowest.get(), options_.max_iterations - newton);
  }
  limit_iterations(options_.max_iterations);
  trouble_ = report.outcome == StageOutcome::converged ? std::max(0, trouble_ - 1) : trouble_ + trouble_of_failure;
  report.newton_iterations = newton;
  report.linear_iterations = linear;
  return report;
}

StageReport NewtonSolver::descend(Vec q, int max_iterations) {
  equation_.extrapolate_from(nullptr);
  assemble(q, Projection::none);
  const double mean = mean_diagonal();
  PetscInt number = 0, of_displacements = 0;
  check(VecGetLocalSize(q, &number));
  check(VecGetLocalSize(equation_.displacements(q), &of_displacements));
  limit_iterations(iterations_of_descent);
  StageReport total;
  double part = first_weight;
  while (total.newton_iterations < max_iterations && part > least_weight) {
    equation_.gradient(q, r_.get());
    scale_ = equation_.force_scale(q);
    const double residual = norm(r_.get());
    if (residual <= options_.relative * scale_) break;
    descent_target_ = part_left * residual;
    proximal_.hold(q, std::min(number, of_displacements), part * mean);
    if (path_ == Path::minimisation) phi_ = value(q);
    factor_is_wanted_ = true;
    merit_has_scale_ = at_rounding_floor_ = false;
    const StageReport report = iterate(q);
    equation_.extrapolate_from(nullptr);
    total.newton_iterations += report.newton_iterations;
    total.linear_iterations += report.linear_iterations;
    if (report.outcome != StageOutcome::converged) {
      // A potential has fallen nevertheless; a residual may lead anywhere.
      if (path_ == Path::residual) check(VecCopy(proximal_.centre(), q));
      part *= 4.0;
    } else if (2 * report.newton_iterations <= iterations_of_descent) {
      part *= 4 * report.newton_iterations <= iterations_of_descent ? 0.25 : 0.5;
    }
    if (report.outcome == StageOutcome::fatal) break;
  }
  proximal_.release();
  descent_target_ = 0.0;
  factor_is_wanted_ = true;
  return total;
}

}  // namespace pliant
