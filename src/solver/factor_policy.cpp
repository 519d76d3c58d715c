#include "solver/factor_policy.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Most iterations that the Krylov method needs with a sound factor of the same matrix.
constexpr int max_fresh_iterations = 40;
/// The same with the factor of its symmetric part: those that are saved by not factorizing the whole matrix, about.
constexpr int max_iterations_with_symmetric_part = 15;
/// Iterations with multigrid for each digit, of `least_digits` at least, beyond which a factorization is likely to take
/// less time. Measured on beams, cubes and thin walls of 25,000 unknowns (1.6 to 4, where multigrid takes a third to
/// two thirds of the time); the times are about equal at 5, and for more unknowns or ranks at more.
constexpr double max_multigrid_per_digit = 6.0;
constexpr double least_digits = 3.0;

}  // namespace

void FactorPolicy::note_set_up(SetUp outcome) {
  has_failed_ = outcome != SetUp::sound;
  lacks_memory_ = outcome == SetUp::out_of_memory;
  is_wanted_ = has_failed_ || solver_ == Solver::direct;
  excess_ = 0.0;
}

void FactorPolicy::note_failure() {
  has_failed_ = is_wanted_ = true;
}

void FactorPolicy::note_solve(const Solve& solve, Factor factor) {
  if (factor == Factor::own) {
    fresh_rate_ = solve.iterations / solve.digits;
    return;
  }
  excess_ += std::max(0.0, solve.iterations - (fresh_rate_ * solve.digits + 1.0));
  if (excess_ > solve.cost_of_set_up) is_wanted_ = true;
}

bool FactorPolicy::is_poor(const Solve& solve, Factor factor, Factored factored) {
  double most = 0.0;
  switch (factored) {
    case Factored::whole:
      most = max_fresh_iterations;
      break;
    case Factored::symmetric_part:
      most = max_iterations_with_symmetric_part;
      break;
    case Factored::nothing:
      most = max_multigrid_per_digit * std::max(solve.digits, least_digits);
  }
  return factor == Factor::own && solve.iterations > most;
}

}  // namespace pliant
