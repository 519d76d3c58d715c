#include "solver/tangent_system.hpp"

namespace pliant {
namespace {

constexpr double relative_residual = 1e-10;

}  // namespace

bool TangentSystem::begin(Vec q, Vec from) {
  q_ = q;
  StageEquation& equation = objective_.equation();
  equation.extrapolate_from(from);
  // The solution may be any equilibrium: K must stay as it is.
  if (is_symmetric(equation.symmetry())) objective_.set_aim(Aim::any_equilibrium);
  system_.assemble(q);
  check(KSPSetTolerances(ksp_, relative_residual, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  return system_.prepare(q);
}

bool TangentSystem::has_solved() const {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  return reason > 0;
}

bool TangentSystem::solve(Vec r, Vec y) {
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

void TangentSystem::end() {
  system_.use_usual_krylov_method();
  objective_.set_aim(objective_.usual_aim());
}

}  // namespace pliant
