/// The linear system of an iterate of Newton's method.
#pragma once

#include "energy/rank_one.hpp"
#include "petsc/handle.hpp"
#include "solver/corotated_preconditioner.hpp"
#include "solver/escalation.hpp"
#include "solver/factor_policy.hpp"
#include "solver/objective.hpp"
#include "solver/rank_one_system.hpp"
#include "solver/statistics.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace pliant {

/// K y = r: the Hessian K of the objective at an iterate, the factor that preconditions it, and the Krylov method
/// around it. FactorPolicy says when the factor of an earlier K is kept, Escalation what is done to K where its
/// solution is no use; this class brings it about.
///
/// Parts of rank one (the pressure of a cavity depends on its volume) are no part of K: the system takes them in by
/// Woodbury's formula (RankOneSystem). A kept factor rotates with the nodes where the equation knows how
/// (CorotatedPreconditioner).
///
/// The aim of the objective decides what K must be like. For a minimum it has no more negative eigenvalues than a
/// stable state has: where the factorization counts others, its diagonal is shifted by the least that helps, or it is
/// projected. Any equilibrium takes it as it is, and another Krylov method where it is indefinite. Pivots of an
/// unsymmetric K say nothing of stability.
///
/// Invariants:
/// - After `assemble` and the changes of K that follow it, the state of the escalation says what K is.
/// - Nothing else sets up the preconditioner; SNES and KSP are told to leave it as it is.
///
/// All methods are collective.
class LinearSystem {
 public:
  /// `ksp` was configured for K (configure_linear_solver, and options). The references outlive the object, and so does
  /// the KSP.
  LinearSystem(Objective& objective, KSP ksp, Handle<Mat> K, SolverStatistics& statistics);

  /// K with its parts of rank one, as an operator.
  Mat matrix() const { return rank_one_ ? rank_one_->matrix() : K_.get(); }
  Mat sparse_matrix() const { return K_.get(); }

  FactorPolicy& factor() { return factor_; }
  const FactorPolicy& factor() const { return factor_; }
  const Escalation& escalation() const { return escalation_; }

  /// K = the Hessian at q.
  void assemble(Vec q, Projection projection = Projection::none);
  /// Mean of the absolute diagonal of K.
  double mean_diagonal();
  /// Factorizes the K of q; where the aim needs it, K is shifted or projected until it is definite. False if that
  /// fails.
  bool factorize_definite(Vec q);
  /// Makes the K of q ready to be solved with: with the kept factor if that still pays, else with one of its own, of
  /// whatever the escalation leads to. False if none can be had.
  bool prepare(Vec q);

  /// y = K^-1 r.
  void solve(Vec r, Vec y);
  /// Whether the solution of the last system, whose right-hand side was r, is a direction to go.
  bool has_direction(Vec r) const;
  /// Books what the last solve cost: a kept factor ages.
  void note_solve();
  /// While the factor of this very K leaves too many iterations: makes it more exact, and solves again.
  void improve_poor_factor(Vec q, Vec r, Vec y);
  /// Goes on in the fallback sequence until K has a factor; false if only a smaller step is left.
  bool escalate(Vec q);

  /// Whether the factorization counts as many negative eigenvalues as a stable state has.
  bool has_right_inertia() const;
  /// Back to the Krylov method of definite matrices, which indefinite ones may have replaced.
  void use_usual_krylov_method();
  /// Forgets what earlier stages have taught.
  void forget();

 private:
  FactorPolicy::Factor whose_factor() const {
    return escalation_.has_kept_factor() ? FactorPolicy::Factor::kept : FactorPolicy::Factor::own;
  }
  void factorize(Vec q);
  /// Adds to the diagonal of K.
  void shift(double by);
  /// Conjugate gradients for a definite Hessian, GMRES for another.
  void choose_krylov_method();
  /// Of the Hessian with its parts of rank one, as the factorization of the present K counts them.
  std::optional<PetscInt> negative_eigenvalues() const;
  PetscInt last_iterations() const;

  Objective& objective_;
  StageEquation& equation_;
  SolverStatistics& statistics_;
  KSP ksp_;
  Handle<Mat> K_;
  Handle<PC> preconditioner_;  // of K
  Handle<Vec> diagonal_;
  std::vector<RankOne> parts_;                          // of the Hessian, besides K
  std::unique_ptr<RankOneSystem> rank_one_;             // nullptr if there are no such parts
  std::unique_ptr<NodalRotations> rotations_;           // since the factorization; nullptr if it does not rotate
  std::unique_ptr<CorotatedPreconditioner> corotated_;  // nullptr likewise
  FactorPolicy factor_;
  Escalation escalation_;
  bool may_choose_krylov_;   // the linear solver is conjugate gradients, and the user did not ask for it
  double last_shift_ = 0.0;  // of an indefinite Hessian, as a part of its mean diagonal
};

}  // namespace pliant
