#include "solver/tangent_system.hpp"

#include "solver/merit.hpp"

#include <algorithm>

namespace pliant {

bool TangentSystem::begin(Vec q, Vec from) {
  q_ = q;
  StageEquation& equation = objective_.equation();
  equation.extrapolate_from(from);
  // The solution may be any equilibrium: K must stay as it is.
  if (is_symmetric(equation.symmetry())) objective_.set_aim(Aim::any_equilibrium);
  system_.assemble(q);
  return system_.prepare(q);
}

bool TangentSystem::has_solved() const {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  return reason > 0;
}

bool TangentSystem::solve(Vec r, Vec y, double part) {
  check(KSPSetTolerances(ksp_, part, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  system_.solve(r, y);
  system_.improve_poor_factor(q_, r, y);
  system_.note_solve();
  if (has_solved()) return true;
  // The factor may be that of a definite matrix, or too rough to show that this one is indefinite.
  system_.factor().renew();
  if (!system_.prepare(q_)) return false;
  system_.use_krylov_method_for_indefinite();
  system_.solve(r, y);
  if (has_solved()) return true;
  if (!system_.refine(q_)) return false;
  system_.solve(r, y);
  return has_solved();
}

bool TangentSystem::solve_from(Vec guess, Vec r, Vec y, double part) {
  if (guess == nullptr) return solve(r, y, part);
  multiply(guess, y);
  check(VecAXPY(y, 1.0, r));
  const double left = norm(r), target = part * norm(y);
  check(VecZeroEntries(y));
  return left <= target || solve(r, y, target / left);
}

bool TangentSystem::solve(std::span<const Vec> r, std::span<const Vec> guesses, std::span<const Vec> y, double part) {
  for (std::size_t first = 0; first < r.size(); first += num_several) {
    const std::size_t count = std::min(num_several, r.size() - first);
    const auto some = [&](std::span<const Vec> all) { return all.subspan(first, count); };
    if (count > 1 && system_.solve_several(some(r), some(guesses), some(y), part)) continue;
    for (std::size_t n = first; n < first + count; ++n) {
      if (!solve_from(guesses[n], r[n], y[n], part)) return false;
    }
  }
  return true;
}

void TangentSystem::end() {
  system_.use_usual_krylov_method();
  objective_.set_aim(objective_.usual_aim());
}

}  // namespace pliant
