/// A preconditioner that rotates with the body.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/handle.hpp"

namespace pliant {

/// R P R^T, where P is a preconditioner of an earlier matrix and R holds the rotations of the nodes since then
/// (NodalRotations). It is close to the inverse of the current matrix if the body has mainly rotated.
class CorotatedPreconditioner {
 public:
  /// Replaces the preconditioner of `ksp`, which becomes P. `rotations` outlives the object.
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
