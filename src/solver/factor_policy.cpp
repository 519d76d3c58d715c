#include "solver/factor_policy.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Most iterations that the Krylov method needs with a sound factor of the same matrix.
constexpr int max_fresh_iterations = 40;
/// The same with the factor of its symmetric part: those that are saved by not factorizing the whole matrix, about.
constexpr int max_iterations_with_symmetric_part = 15;

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

bool FactorPolicy::is_poor(int iterations, Factor factor, Factored factored) {
  const int most = factored == Factored::whole ? max_fresh_iterations : max_iterations_with_symmetric_part;
  return factor == Factor::own && iterations > most;
}

}  // namespace pliant
