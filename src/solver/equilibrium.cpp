#include "solver/equilibrium.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Iterations to a nearby equilibrium: Newton's method converges quadratically.
constexpr int max_followed = 8;
/// Iterations to a nearby minimum where bodies meet, which have to find out where.
constexpr int max_meeting = 16;
/// Whole steps converge within a few, or not at all.
constexpr int max_whole_steps = 12;
/// How much a stage without an equilibrium adds to the count of difficulties, from which each other stage subtracts
/// one, and the count from which a body may snap to a distant equilibrium. Before that, shorter steps may find a
/// nearby one.
constexpr int trouble_of_failure = 2, trouble_before_snap = 4;
/// A body that snaps may take this many times the usual number of iterations.
constexpr int times_to_snap = 20;
/// Weights that hold the solutions of a descent, as fractions of the Hessian's mean diagonal.
constexpr double first_weight = 1e-3, least_weight = 1e-9, largest_weight = 1e6;
/// By which factor weights fall that hold bodies until friction does; of how far they have come since the guess, what
/// counts as no motion; and how often in a row they may continue as if nothing but the weight held them.
constexpr double softer = 0.1, nearly_at_rest = 1e-2;
constexpr int most_slides = 2;
/// Such a solution may leave this fraction of the previous residual,
constexpr double part_left = 0.1;
/// and takes at most this many iterations; if it takes half as many or more, the weight stays.
constexpr int iterations_of_descent = 8;

/// Number of displacement unknowns on this rank; they come first.
PetscInt num_local_displacements(StageEquation& equation, Vec q) {
  PetscInt number = 0, of_displacements = 0;
  check(VecGetLocalSize(q, &number));
  check(VecGetLocalSize(equation.displacements(q), &of_displacements));
  return std::min(number, of_displacements);
}

}  // namespace

EquilibriumSearch::EquilibriumSearch(Objective& objective, Iteration& iteration, SolverStatistics& statistics,
                                     double relative, Slenderness slenderness)
    : objective_(objective),
      iteration_(iteration),
      statistics_(statistics),
      relative_(relative),
      slenderness_(slenderness) {}

void EquilibriumSearch::forget() {
  prefers_following_ = false;
  prefers_whole_steps_ = false;
  trouble_ = 0;
}

bool EquilibriumSearch::attempt(Vec q, Vec guess, Aim aim, int max_iterations, Work& work) {
  if (max_iterations <= 0) return false;
  const int before = work.report.newton_iterations;
  int newton = before, linear = work.report.linear_iterations;
  check(VecCopy(guess, q));
  if (newton > 0) iteration_.renew_factor();
  iteration_.begin(q, aim);
  const int end = before + std::max(max_iterations, work.limit);
  do {
    work.report = iteration_.run(q, max_iterations);
    newton += work.report.newton_iterations;
    linear += work.report.linear_iterations;
  } while (work.report.outcome == StageOutcome::retry && newton < end && iteration_.is_converging());
  work.report.newton_iterations = newton;
  work.report.linear_iterations = linear;
  if (work.report.outcome == StageOutcome::converged) {
    prefers_following_ = aim == Aim::any_equilibrium && !iteration_.is_stable(q);
    if (prefers_following_) ++statistics_.unstable_stages;
  }
  objective_.set_aim(objective_.usual_aim());
  return work.is_over();
}

StageReport EquilibriumSearch::seek(Vec q, Vec second_guess, int max_iterations) {
  const Aim usual = objective_.usual_aim();
  const Handle<Vec> best = objective_.equation().make_vector(), lowest = objective_.equation().make_vector();
  check(VecCopy(q, best.get()));
  check(VecCopy(q, lowest.get()));
  Work work;
  work.limit = max_iterations;
  const auto few = [&] { return std::min(max_followed, work.left()); };
  const auto minimise = [&] {
    const int near = objective_.equation().has_walls() ? max_meeting : max_followed;
    const bool arrives = attempt(q, best.get(), usual, std::min(near, work.left()), work);
    check(VecCopy(q, lowest.get()));
    return arrives || objective_.equation().is_far_from_guess(q);
  };
  const auto follow = [&] {
    return attempt(q, best.get(), Aim::any_equilibrium, few(), work) ||
           (second_guess != nullptr && attempt(q, second_guess, Aim::any_equilibrium, few(), work));
  };
  const auto take_whole_steps = [&] {
    if (slenderness_ == Slenderness::none) return false;
    const int at_most = std::min(max_whole_steps, work.left());
    const bool is_over = attempt(q, best.get(), Aim::whole_steps, at_most, work);
    prefers_whole_steps_ = is_over && work.report.outcome == StageOutcome::converged && iteration_.is_stable(q);
    if (is_over && !prefers_whole_steps_) work.report.outcome = StageOutcome::retry;
    return prefers_whole_steps_;
  };
  const auto go_near = [&] {
    if (prefers_whole_steps_) return take_whole_steps() || minimise();
    return minimise() || take_whole_steps();
  };
  const bool arrives = prefers_following_ ? follow() || go_near() : go_near() || follow();
  if (!arrives && trouble_ >= trouble_before_snap && max_iterations > 3 * max_followed) {
    trouble_ = 0;  // if this does not help, shorter steps may
    check(VecCopy(lowest.get(), q));
    const StageReport descent = descend(q, times_to_snap * max_iterations);
    work.report.newton_iterations += descent.newton_iterations;
    work.report.linear_iterations += descent.linear_iterations;
    check(VecCopy(q, lowest.get()));
    attempt(q, lowest.get(), usual, max_iterations, work);
  } else if (!arrives) {
    attempt(q, lowest.get(), usual, work.left(), work);
  }
  trouble_ = work.report.outcome == StageOutcome::converged ? std::max(0, trouble_ - 1) : trouble_ + trouble_of_failure;
  return work.report;
}

StageReport EquilibriumSearch::hold_softly(Vec q, int max_iterations) {
  StageEquation& equation = objective_.equation();
  Proximal& proximal = objective_.proximal();
  const double mean = iteration_.stiffness(q);
  const PetscInt number = num_local_displacements(equation, q);
  const Handle<Vec> centre = equation.make_vector(), way = equation.make_vector(), step = equation.make_vector();
  check(VecCopy(q, centre.get()));
  StageReport total;
  int num_slides = 0;
  double last = 0.0;
  for (double part = first_weight; part >= least_weight; part *= softer) {
    check(VecCopy(q, step.get()));
    proximal.hold(centre.get(), number, part * mean);
    iteration_.renew_factor();
    iteration_.begin(q, objective_.usual_aim());
    const StageReport report = iteration_.run(q, max_iterations);
    total = {report.outcome,
             {},
             total.newton_iterations + report.newton_iterations,
             total.linear_iterations + report.linear_iterations};
    if (report.outcome != StageOutcome::converged) break;
    equation.freeze(q);
    check(VecAYPX(step.get(), -1.0, q));
    check(VecWAXPY(way.get(), -1.0, centre.get(), q));
    const double length = norm(step.get());
    if (part < first_weight && length <= nearly_at_rest * norm(way.get())) break;
    // What nothing holds moves in inverse proportion to the weight.
    num_slides = last > 0.0 && length > 0.5 / softer * last ? num_slides + 1 : 0;
    last = length;
    if (num_slides == most_slides) {
      total.outcome = StageOutcome::retry;
      total.reason = "nothing holds the bodies against the loads, not even friction";
      break;
    }
  }
  proximal.release();
  iteration_.renew_factor();
  return total;
}

StageReport EquilibriumSearch::descend(Vec q, int max_iterations) {
  StageEquation& equation = objective_.equation();
  Proximal& proximal = objective_.proximal();
  const Handle<Vec> r = equation.make_vector();
  equation.extrapolate_from(nullptr);
  const double mean = iteration_.stiffness(q);
  const PetscInt number = num_local_displacements(equation, q);
  StageReport total;
  double part = first_weight;
  while (total.newton_iterations < max_iterations && part > least_weight && part < largest_weight) {
    equation.gradient(q, r.get());
    const double residual = norm(r.get());
    if (residual <= relative_ * equation.force_scale(q)) break;
    iteration_.accept(part_left * residual);
    proximal.hold(q, number, part * mean);
    iteration_.renew_factor();
    iteration_.begin(q, objective_.usual_aim());
    const StageReport report = iteration_.run(q, iterations_of_descent);
    equation.extrapolate_from(nullptr);
    total.newton_iterations += report.newton_iterations;
    total.linear_iterations += report.linear_iterations;
    if (report.outcome != StageOutcome::converged) {
      // A potential has decreased nevertheless; iterations on the residual guarantee nothing.
      if (!objective_.is_minimised()) check(VecCopy(proximal.centre(), q));
      part *= 4.0;
    } else if (2 * report.newton_iterations <= iterations_of_descent) {
      part *= 4 * report.newton_iterations <= iterations_of_descent ? 0.25 : 0.5;
    }
    if (report.outcome == StageOutcome::fatal || equation.is_far_from_guess(q)) break;
  }
  proximal.release();
  iteration_.accept(0.0);
  iteration_.renew_factor();
  return total;
}

}  // namespace pliant
