#include "solver/corotated_preconditioner.hpp"

#include "petsc/callback.hpp"

namespace pliant {

CorotatedPreconditioner::CorotatedPreconditioner(KSP ksp, const NodalRotations& rotations) : rotations_(rotations) {
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectReference(reinterpret_cast<PetscObject>(pc)));
  inner_ = Handle<PC>(pc);
  Mat A = nullptr, K = nullptr;
  check(KSPGetOperators(ksp, &A, &K));
  check(MatCreateVecs(K, rotated_back_.out(), nullptr));
  Handle<PC> outer;
  check(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(ksp)), outer.out()));
  check(PCSetType(outer.get(), PCSHELL));
  check(PCShellSetName(outer.get(), "an earlier factorization, rotated with the nodes"));
  check(PCShellSetContext(outer.get(), this));
  check(PCShellSetApply(outer.get(), apply_callback));
  check(PCShellSetView(outer.get(), view_callback));
  check(KSPSetPC(ksp, outer.get()));
  check(KSPSetOperators(ksp, A, K));
}

void CorotatedPreconditioner::apply(Vec x, Vec y) {
  check(VecCopy(x, rotated_back_.get()));
  rotations_.turn_back(rotated_back_.get());
  check(PCApply(inner_.get(), rotated_back_.get(), y));
  rotations_.turn(y);
}

PetscErrorCode CorotatedPreconditioner::apply_callback(PC pc, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] { static_cast<CorotatedPreconditioner*>(self)->apply(x, y); });
}

PetscErrorCode CorotatedPreconditioner::view_callback(PC pc, PetscViewer viewer) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return PCView(static_cast<CorotatedPreconditioner*>(self)->inner_.get(), viewer);
}

}  // namespace pliant
