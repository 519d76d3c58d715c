/// Linear systems with a sparse matrix and a few rank-one terms.
#pragma once

#include "energy/rank_one.hpp"
#include "petsc/callback.hpp"
#include "petsc/handle.hpp"

#include <functional>
#include <vector>

namespace pliant {

/// A = K + sum_k c_k g_k g_k^T as an operator, and its preconditioner made from one of K, P ~ K^-1, by the
/// Sherman-Morrison-Woodbury formula: with Z = P G, D = diag(sqrt c) and the small matrix T = I + D G^T Z D,
///
///     A^-1 ~ P - Z D T^-1 D Z^T
///
/// (Golub & Van Loan, Matrix Computations, 2.1.4). It is exact if P is. A then has as many negative eigenvalues as K
/// minus those of T: a rank-one term may make A definite although the sparse matrix is not.
class RankOneSystem {
 public:
  /// Replaces the preconditioner of `ksp`, which remains in use for K. `parts` and K outlive the object.
  RankOneSystem(KSP ksp, Mat K, const std::vector<RankOne>& parts);
  RankOneSystem(const RankOneSystem&) = delete;  // PETSc's objects point to it
  RankOneSystem& operator=(const RankOneSystem&) = delete;

  /// A.
  Mat matrix() const { return A_.get(); }
  /// The preconditioner of K.
  PC inner() const { return inner_.get(); }
  /// To be called after `inner` was set up. Keeps Z and T until the next call, while the rank-one terms of A may
  /// change. Returns false if T is singular. Collective.
  /// `clear`, if it is given, sets entries to zero that P does not act on.
  bool set_up(const std::function<void(Vec)>& clear = {});
  /// Number of negative eigenvalues of T.
  PetscInt negative_eigenvalues() const { return negative_; }

 private:
  static PetscErrorCode multiply_callback(Mat A, Vec x, Vec y);
  static PetscErrorCode apply_callback(PC pc, Vec x, Vec y);
  static PetscErrorCode view_callback(PC pc, PetscViewer viewer);
  void multiply(Vec x, Vec y) const;
  void apply(Vec x, Vec y) const;

  Mat K_;
  const std::vector<RankOne>& parts_;
  Handle<Mat> A_;
  Handle<PC> inner_;
  std::vector<Handle<Vec>> directions_;  // D G of the last set-up
  std::vector<Handle<Vec>> solutions_;   // Z D
  std::vector<double> factors_;          // L and U of T in one, row by row
  PetscInt negative_ = 0;
};

}  // namespace pliant
