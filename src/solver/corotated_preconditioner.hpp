/// A preconditioner that rotates with the body.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"

namespace pliant {

/// R P R^T, where P is a preconditioner made of an earlier matrix and R are the rotations of the nodes since
/// (NodalRotations): close to the inverse of the present matrix where the body has mainly rotated.
class CorotatedPreconditioner {
 public:
  /// Takes the place of the preconditioner of `ksp`, which becomes P. `rotations` outlive the object.
  CorotatedPreconditioner(KSP ksp, const NodalRotations& rotations);
  CorotatedPreconditioner(const CorotatedPreconditioner&) = delete;  // PETSc's objects point to it
  CorotatedPreconditioner& operator=(const CorotatedPreconditioner&) = delete;

 private:
  static PetscErrorCode apply_callback(PC pc, Vec x, Vec y);
  static PetscErrorCode view_callback(PC pc, PetscViewer viewer);
  void apply(Vec x, Vec y);

  const NodalRotations& rotations_;
  Handle<PC> inner_;
  Handle<Vec> rotated_back_;
};

}  // namespace pliant
