#include "solver/operator_system.hpp"

namespace pliant {
namespace {

constexpr PetscInt most_iterations = 60;

}  // namespace

OperatorSystem::OperatorSystem(Vec like) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(like));
  PetscInt size = 0;
  check(VecGetLocalSize(like, &size));
  check(MatCreateShell(comm, size, size, PETSC_DETERMINE, PETSC_DETERMINE, this, A_.out()));
  check(MatShellSetOperation(A_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  check(KSPCreate(comm, ksp_.out()));
  check(KSPSetType(ksp_.get(), KSPFGMRES));
  check(KSPGMRESSetRestart(ksp_.get(), most_iterations));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetContext(pc, this));
  check(PCShellSetApply(pc, precondition_callback));
  check(KSPSetOperators(ksp_.get(), A_.get(), A_.get()));
}

bool OperatorSystem::solve(const Function& product, const Function& inverse, Vec r, Vec y, double tolerance) {
  product_ = &product;
  inverse_ = &inverse;
  check(KSPSetTolerances(ksp_.get(), tolerance, PETSC_DEFAULT, PETSC_DEFAULT, most_iterations));
  guard_.rethrow(KSPSolve(ksp_.get(), r, y));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_.get(), &reason));
  return reason > 0;
}

PetscErrorCode OperatorSystem::multiply_callback(Mat A, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  auto* system = static_cast<OperatorSystem*>(self);
  return system->guard_.run([&] { (*system->product_)(x, y); });
}

PetscErrorCode OperatorSystem::precondition_callback(PC pc, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  auto* system = static_cast<OperatorSystem*>(self);
  return system->guard_.run([&] { (*system->inverse_)(x, y); });
}

}  // namespace pliant
