#include "solver/reduced_system.hpp"

#include "petsc/array_view.hpp"
#include "petsc/callback.hpp"

#include <algorithm>

namespace pliant {

Handle<Vec> make_state_vector(Vec q) {
  PetscInt size = 0;
  check(VecGetLocalSize(q, &size));
  Handle<Vec> y;
  check(VecCreateMPI(PetscObjectComm(reinterpret_cast<PetscObject>(q)), 2 * size, PETSC_DECIDE, y.out()));
  return y;
}

void split(Vec y, Vec q, Vec v) {
  const ConstArrayView from(y);
  const ArrayView to_q(q), to_v(v);
  const auto middle = from.span().begin() + static_cast<std::ptrdiff_t>(to_q.span().size());
  std::copy(from.span().begin(), middle, to_q.span().begin());
  std::copy(middle, from.span().end(), to_v.span().begin());
}

void join(Vec q, Vec v, Vec y) {
  const ConstArrayView from_q(q), from_v(v);
  const ArrayView to(y);
  const auto middle = std::copy(from_q.span().begin(), from_q.span().end(), to.span().begin());
  std::copy(from_v.span().begin(), from_v.span().end(), middle);
}

ReducedSystem::ReducedSystem(const StageEquation& equation, LinearKind linear)
    : H_(equation.make_hessian()), a_(equation.make_vector()), b_(equation.make_vector()), c_(equation.make_vector()) {
  PetscInt size = 0;
  check(VecGetLocalSize(a_.get(), &size));
  check(MatCreateShell(equation.comm(), 2 * size, 2 * size, PETSC_DETERMINE, PETSC_DETERMINE, this, J_.out()));
  check(MatShellSetOperation(J_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  check(KSPCreate(equation.comm(), ksp_.out()));
  configure_linear_solver(ksp_.get(), H_.get(), linear, equation.symmetry());
}

void ReducedSystem::configure(KSP ksp) {
  // The options -ksp_ and -pc_ refer to the systems in q.
  check(KSPSetOptionsPrefix(ksp, "state_"));
  check(KSPSetType(ksp, KSPPREONLY));
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetContext(pc, this));
  check(PCShellSetApply(pc, solve_callback));
}

void ReducedSystem::multiply(Vec x, Vec y) {
  split(x, a_.get(), b_.get());
  check(MatMult(H_.get(), a_.get(), c_.get()));
  check(VecAXPBY(b_.get(), sigma_, -1.0, a_.get()));
  join(b_.get(), c_.get(), y);
}

bool ReducedSystem::solve(Vec r, Vec x) {
  split(r, b_.get(), a_.get());
  check(KSPSolve(ksp_.get(), a_.get(), c_.get()));
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp_.get(), &iterations));
  linear_iterations_ += iterations;
  check(VecAXPBY(b_.get(), sigma_, -1.0, c_.get()));
  join(c_.get(), b_.get(), x);
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  return reason > 0;
}

PetscErrorCode ReducedSystem::multiply_callback(Mat J, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(J, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] { static_cast<ReducedSystem*>(self)->multiply(x, y); });
}

PetscErrorCode ReducedSystem::solve_callback(PC pc, Vec r, Vec x) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] {
    const bool solved = static_cast<ReducedSystem*>(self)->solve(r, x);
    check(PCSetFailedReason(pc, solved ? PC_NOERROR : PC_SUBPC_ERROR));
  });
}

}  // namespace pliant
