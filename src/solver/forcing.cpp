#include "solver/forcing.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// The linear residual as a fraction of the nonlinear remainder, or of the target.
constexpr double residual_part = 0.3;
/// The tolerance of an iteration without a predecessor.
constexpr double first_guess = 1e-3;
/// Bounds of the tolerance: looser ones make poor Newton directions, tighter ones reach rounding errors.
constexpr double loosest = 3e-2, tightest = 1e-10;

}  // namespace

double Forcing::tolerance(int iteration, double residual, double target) {
  iteration_ = std::min(iteration, num_remembered - 1);
  residual_ = residual;
  const double left_out = left_out_[iteration_];
  const double wanted = left_out == unknown ? first_guess : residual_part * left_out;
  tolerance_ = std::clamp(std::max(wanted, residual_part * target / residual), tightest, loosest);
  return tolerance_;
}

void Forcing::observe(double residual) {
  const double ratio = residual / residual_;
  // Where the linear residual dominates, the remainder is smaller by an unknown amount: tighten the next tolerance.
  left_out_[iteration_] = ratio > 2.0 * tolerance_ ? ratio : 0.1 * tolerance_;
}

}  // namespace pliant
