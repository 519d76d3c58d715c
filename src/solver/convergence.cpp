#include "solver/convergence.hpp"

#include "solver/line_search.hpp"

#include <cmath>
#include <utility>

namespace pliant {
namespace {

/// How often the scale may be lowered to the forces at the iterate, each time after the tolerance is met. A solution
/// without stress has no forces; an iterate that has met the tolerance this often is accepted.
constexpr int max_lowered = 3;
/// The forces of a guess are too large a scale if those at the iterate are less than this fraction of them.
constexpr double much_less = 0.1;
/// Forces below this fraction of those of the guess count as zero, and without inertia residuals below this fraction of
/// one that was tolerated before: where bodies part again, exactly at the end of a step, their forces vanish.
constexpr double tiny_part = 1e-6;
/// The scale is not lowered below this fraction of that of the guess. Forces and residual of an iterate near a solution
/// without stress fall together, down to numbers like 1e-50 N, without meeting any tolerance.
constexpr double least_part = 1e-12;
/// A residual above this part of that of the iterate before does not fall any more.
constexpr double settled = 0.5;
/// Less than any force on a body [N], but more than the least number in single precision. Bodies whose loads are gone
/// come nearer to rest with each static stage.
constexpr double no_force = 1e-30;
/// Forces up to this multiple of the rounding floor count as zero.
constexpr double no_forces = 10.0;

}  // namespace

Convergence::Convergence(Objective& objective, const NewtonOptions& options, SolverStatistics& statistics,
                         std::function<void(Vec)> reassemble)
    : objective_(objective), options_(options), statistics_(statistics), reassemble_(std::move(reassemble)) {}

void Convergence::begin_stage() {
  scale_ = 0.0;
  is_rounding_counted_ = false;
  least_target_ = objective_.is_static() ? std::max(no_force, tiny_part * options_.relative * largest_scale_) : 0.0;
  starts_at_solution_ = false;
}

void Convergence::measure_guess(Vec q) {
  measure(q);
  first_scale_ = scale_;
}

Convergence::Verdict Convergence::judge(int iteration, double residual, Vec q, bool line_search_is_at_rounding) {
  if (!std::isfinite(residual)) return Verdict::not_a_number;
  if (iteration == 0) num_lowered_ = 0;
  if (iteration > 0 && residual <= target() && num_lowered_ < max_lowered) {
    lower_scale(q);
    if (residual > target()) ++num_lowered_;
  }
  if (residual <= target()) {
    if (residual > unbalanced_part * scale_) ++statistics_.unbalanced_stops;
    largest_scale_ = std::max(largest_scale_, scale_);
    return Verdict::converged;
  }
  if (iteration == 0) {
    start_ = {residual, norm(q)};
    size_at_start_ = size_of(q);
  }
  has_settled_ = iteration > 0 && residual > settled * last_residual_;
  last_residual_ = residual;
  const bool may_be_rounding = iteration > 0 || starts_at_solution_;
  if (!line_search_is_at_rounding && !(may_be_rounding && is_rounding(residual, q))) return Verdict::iterating;
  count_rounding(residual, q);
  return Verdict::at_rounding;
}

bool Convergence::is_solution(double residual, Vec q) {
  has_settled_ = false;
  lower_scale(q);
  return residual <= target() || is_rounding(residual, q);
}

void Convergence::count_rounding(double residual, Vec q) {
  StageEquation& equation = objective_.equation();
  if (!std::exchange(is_rounding_counted_, true)) ++statistics_.rounding_stops;
  const double size = std::max({equation.force_scale(q), equation.inertia_scale(), first_scale_ * tiny_part});
  // A body at rest without stress: its forces are themselves rounding errors.
  const bool is_free_of_forces =
      objective_.is_static() && size <= no_forces * rounding_safety * equation.rounding_floor(q);
  if (size > 0.0 && !is_free_of_forces)
    statistics_.worst_rounding = std::max(statistics_.worst_rounding, residual / size);
}

void Convergence::lower_scale(Vec q) {
  const double now = std::max(objective_.equation().force_scale(q), least_part * first_scale_);
  if (now < much_less * scale_) scale_ = now;
}

// Unknowns of rigid parts count from their place at the guess, and pressures have another unit.
double Convergence::size_of(Vec q) {
  return norm(objective_.equation().displacements(q));
}

bool Convergence::is_rounding(double residual, Vec q) {
  // It is not a number where the constraints cannot be fulfilled.
  double floor = rounding_safety * objective_.equation().rounding_floor(q);
  if (!(residual <= floor)) return false;
  if (residual > doubtful_rounding * scale_) {
    // The last Hessian may stem from a point near a wall that is now far away.
    reassemble_(q);
    floor = rounding_safety * objective_.equation().rounding_floor(q);
    if (!(residual <= floor)) return false;
  }
  // A body that flies without forces starts with rounding errors, and has nothing that falls.
  return start_.allows_rounding(residual, floor, norm(q)) ||
         (has_settled_ && residual * size_of(q) <= floor * size_at_start_);
}

}  // namespace pliant
