/// Linear systems of an operator that has no matrix.
#pragma once

#include "petsc/callback.hpp"
#include "petsc/handle.hpp"

#include <functional>

namespace pliant {

/// A y = r by GMRES, for an operator A and an approximation of its inverse that are functions: Jacobians of which a
/// part has no matrix (Knoll & Keyes 2004, Jacobian-free Newton-Krylov methods). With a good approximation it takes as
/// many iterations as the difference has distinct eigenvalues. Collective.
class OperatorSystem {
 public:
  /// y = A x or about A^-1 x.
  using Function = std::function<void(Vec x, Vec y)>;

  /// Vectors are made like `like`.
  explicit OperatorSystem(Vec like);
  OperatorSystem(const OperatorSystem&) = delete;  // PETSc's objects point to it
  OperatorSystem& operator=(const OperatorSystem&) = delete;

  /// Solves from y = 0 until the residual has fallen to this part of its norm. Returns false if that fails; y is then
  /// the best known.
  bool solve(const Function& product, const Function& inverse, Vec r, Vec y, double tolerance);

 private:
  static PetscErrorCode multiply_callback(Mat A, Vec x, Vec y);
  static PetscErrorCode precondition_callback(PC pc, Vec x, Vec y);

  Handle<Mat> A_;
  Handle<KSP> ksp_;
  const Function *product_ = nullptr, *inverse_ = nullptr;  // of the present solve
  CallbackGuard guard_;
};

}  // namespace pliant
