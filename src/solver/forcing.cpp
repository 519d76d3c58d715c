#include "solver/forcing.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Of the linear residual in what is left out otherwise, or in what is to be reached.
constexpr double part = 0.3;
/// Where nothing is known.
constexpr double first_guess = 1e-3;
/// No solve is worse than the one, lest Newton's directions become poor; none better than the other, where rounding
/// begins.
constexpr double loosest = 3e-2, tightest = 1e-10;

}  // namespace

double Forcing::tolerance(int iteration, double residual, double target) {
  iteration_ = std::min(iteration, num_remembered - 1);
  residual_ = residual;
  const double left_out = left_out_[iteration_];
  const double wanted = left_out == unknown ? first_guess : part * left_out;
  tolerance_ = std::clamp(std::max(wanted, part * target / residual), tightest, loosest);
  return tolerance_;
}

void Forcing::observe(double residual) {
  const double ratio = residual / residual_;
  // Where the linear residual was most of it, what is left out is less, nobody knows how much: look closer next time.
  left_out_[iteration_] = ratio > 2.0 * tolerance_ ? ratio : 0.1 * tolerance_;
}

}  // namespace pliant
