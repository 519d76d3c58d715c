/// A preconditioner that turns with the body.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"

namespace pliant {

/// R P R^T, where P is a preconditioner made of an earlier matrix and R are the rotations of the nodes since
/// (NodalRotations): near the present one's inverse where the body has mainly turned.
class TurnedPreconditioner {
 public:
  /// Takes the place of the preconditioner of `ksp`, which becomes P. `rotations` outlive the object.
  TurnedPreconditioner(KSP ksp, const NodalRotations& rotations);
  TurnedPreconditioner(const TurnedPreconditioner&) = delete;  // PETSc's objects point to it
  TurnedPreconditioner& operator=(const TurnedPreconditioner&) = delete;

 private:
  static PetscErrorCode apply_callback(PC pc, Vec x, Vec y);
  static PetscErrorCode view_callback(PC pc, PetscViewer viewer);
  void apply(Vec x, Vec y);

  const NodalRotations& rotations_;
  Handle<PC> inner_;
  Handle<Vec> turned_back_;
};

}  // namespace pliant
