/// The linear system of a stage whose coefficients follow its unknowns.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/callback.hpp"
#include "petsc/handle.hpp"

namespace pliant {

/// (K + C) y = r, with the Hessian K for frozen coefficients, and C = df/da of the forces f(q; a) whose coefficients
/// are frozen at a (StageEquation::drag), at a = q. C has no matrix: its products are differences of f. GMRES solves
/// the system with the preconditioner of K (Knoll & Keyes 2004, Jacobian-free Newton-Krylov methods), and needs few
/// iterations: C has the rank of what touches, and is small where friction is.
class CoupledSystem {
 public:
  /// The preconditioner is that of `ksp` at the time of a solve. The references outlive the object. Collective.
  CoupledSystem(StageEquation& equation, KSP ksp);
  CoupledSystem(const CoupledSystem&) = delete;  // PETSc's objects point to it
  CoupledSystem& operator=(const CoupledSystem&) = delete;

  /// Solves the system at q, with K frozen there. Returns the number of iterations, 0 if there is no usable solution.
  /// Coefficients end frozen elsewhere. Collective.
  PetscInt solve(Vec q, Mat K, Vec r, Vec y, double tolerance);

 private:
  static PetscErrorCode multiply_callback(Mat A, Vec x, Vec y);
  void multiply(Vec x, Vec y);

  StageEquation& equation_;
  KSP source_;  // of the preconditioner
  Handle<KSP> ksp_;
  Handle<Mat> A_;
  Handle<Vec> here_, there_, at_;  // forces with coefficients of q and of `at_`
  Vec q_ = nullptr;                // of the present solve, borrowed, as K_
  Mat K_ = nullptr;
  double step_ = 0.0;  // largest entry of the solution, roughly
  CallbackGuard guard_;
};

}  // namespace pliant
