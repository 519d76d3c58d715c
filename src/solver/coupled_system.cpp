#include "solver/coupled_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr PetscInt max_iterations = 40;
/// Differences move the configuration by this fraction of the step that is sought, and of the way to a barrier, whose
/// pressure varies with the gap.
constexpr double part_of_step = 1e-2, part_of_way = 1e-4;

double largest(Vec x) {
  PetscReal norm = 0.0;
  check(VecNorm(x, NORM_INFINITY, &norm));
  return norm;
}

}  // namespace

CoupledSystem::CoupledSystem(StageEquation& equation, KSP ksp)
    : equation_(equation),
      source_(ksp),
      here_(equation.make_vector()),
      there_(equation.make_vector()),
      at_(equation.make_vector()) {
  PetscInt size = 0;
  check(VecGetLocalSize(here_.get(), &size));
  check(MatCreateShell(equation.comm(), size, size, PETSC_DETERMINE, PETSC_DETERMINE, this, A_.out()));
  check(MatShellSetOperation(A_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  check(KSPCreate(equation.comm(), ksp_.out()));
  check(KSPSetType(ksp_.get(), KSPGMRES));
  check(KSPGMRESSetRestart(ksp_.get(), max_iterations));
  check(KSPSetPCSide(ksp_.get(), PC_RIGHT));
}

PetscInt CoupledSystem::solve(Vec q, Mat K, Vec r, Vec y, double tolerance) {
  q_ = q;
  K_ = K;
  PC preconditioner = nullptr;
  check(KSPGetPC(source_, &preconditioner));
  check(KSPSetPC(ksp_.get(), preconditioner));
  check(KSPSetOperators(ksp_.get(), A_.get(), K));
  check(KSPSetReusePreconditioner(ksp_.get(), PETSC_TRUE));
  check(KSPSetTolerances(ksp_.get(), tolerance, PETSC_DEFAULT, PETSC_DEFAULT, max_iterations));
  equation_.drag(q, q, here_.get());
  check(PCApply(preconditioner, r, y));
  step_ = largest(y);
  guard_.rethrow(KSPSolve(ksp_.get(), r, y));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  check(KSPGetIterationNumber(ksp_.get(), &iterations));
  return reason > 0 || reason == KSP_DIVERGED_ITS ? std::max<PetscInt>(1, iterations) : 0;
}

void CoupledSystem::multiply(Vec x, Vec y) {
  check(MatMult(K_, x, y));
  const double size = largest(x);
  if (size == 0.0 || step_ == 0.0) return;
  check(VecCopy(x, at_.get()));
  check(VecScale(at_.get(), step_ / size));
  const double part = std::min(part_of_step, part_of_way * equation_.max_step(q_, at_.get()));
  check(VecAYPX(at_.get(), part, q_));
  equation_.drag(q_, at_.get(), there_.get());
  check(VecAXPY(there_.get(), -1.0, here_.get()));
  check(VecAXPY(y, size / (part * step_), there_.get()));
}

PetscErrorCode CoupledSystem::multiply_callback(Mat A, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  auto* system = static_cast<CoupledSystem*>(self);
  return system->guard_.run([&] { system->multiply(x, y); });
}

}  // namespace pliant
