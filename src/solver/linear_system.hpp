/// The linear system of a Newton iteration.
#pragma once

#include "energy/rank_one.hpp"
#include "petsc/handle.hpp"
#include "petsc/work_vector.hpp"
#include "solver/bordered_system.hpp"
#include "solver/corotated_preconditioner.hpp"
#include "solver/escalation.hpp"
#include "solver/factor_policy.hpp"
#include "solver/objective.hpp"
#include "solver/rank_one_system.hpp"
#include "solver/several_systems.hpp"
#include "solver/statistics.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace pliant {

/// K y = r: the Hessian K (tangent stiffness) of the objective at an iterate, the factor that preconditions it, and the
/// Krylov method. FactorPolicy decides when the factor of an earlier K is kept, Escalation how K is changed if its
/// solution is of no use; this class carries out both.
///
/// Rank-one terms (the pressure of a cavity depends on its volume) are not stored in K: the system includes them by
/// Woodbury's formula (RankOneSystem). A kept factor rotates with the nodes if the equation provides their rotations
/// (CorotatedPreconditioner). Where only a few rows of K are unsymmetric, they are eliminated, and the factor is that
/// of the rest (BorderedSystem).
///
/// The requirements on K depend on the aim of the objective. For a minimum, K must have no more negative eigenvalues
/// than that of a stable state: if the factorization counts more, barriers are projected, the diagonal is shifted by
/// the least amount that helps, or all of K is projected. For any equilibrium, K is used unchanged, with another Krylov
/// method if it is indefinite. The pivots of an unsymmetric K do not indicate stability.
///
/// Invariants:
/// - After `assemble` and the changes of K that follow it, the state of the escalation says what K is.
/// - Only this class sets up the preconditioner; SNES and KSP are configured not to.
///
/// All methods are collective.
class LinearSystem {
 public:
  /// `ksp` has been configured for K (configure_linear_solver, and options). The KSP and the references outlive the
  /// object.
  LinearSystem(Objective& objective, KSP ksp, Handle<Mat> K, SolverStatistics& statistics);

  /// K with its rank-one terms, as an operator.
  Mat matrix() const { return rank_one_ ? rank_one_->matrix() : K_.get(); }
  Mat sparse_matrix() const { return K_.get(); }

  FactorPolicy& factor() { return factor_; }
  const FactorPolicy& factor() const { return factor_; }
  const Escalation& escalation() const { return escalation_; }

  /// K = the Hessian at q.
  void assemble(Vec q, Projection projection = Projection::none);
  /// Mean of the absolute diagonal of K.
  double mean_diagonal();
  /// Factorizes K at q; if the aim requires it, shifts or projects K until it is definite. Returns false if that fails.
  bool factorize_definite(Vec q);
  /// What is tried first where K is indefinite at barriers.
  enum class Remedy {
    projected_walls,  ///< barriers without their negative curvature: far the cheapest, and it rarely fails
    shifted_diagonal  ///< the least shift, which keeps Newton's steps long along negative curvature
  };
  /// Prepares solves with K at q: with the kept factor if that still pays, otherwise with a factor of its own,
  /// escalating as necessary. Returns false if no factor can be computed.
  bool prepare(Vec q, Remedy first = Remedy::projected_walls);
  /// Whether K was made definite by projected barriers, as the K of the next iterate is likely to need.
  bool projects_walls() const { return projects_walls_; }
  /// Does the work of `assemble` and `prepare` with projected barriers from the start.
  bool prepare_with_projected_walls(Vec q);

  /// y = K^-1 r.
  void solve(Vec r, Vec y);
  /// Several systems at once, at most `num_several`, as SeveralSystems solves them. Returns false, with y undefined,
  /// where one after another has to be solved: K is not definite, or the factor is not one for several vectors or too
  /// rough. Records the cost.
  bool solve_several(std::span<const Vec> r, std::span<const Vec> guesses, std::span<const Vec> y, double part);
  /// Whether the solution of the last system, with the right-hand side r, is a usable direction.
  bool has_direction(Vec r) const;
  /// Records the cost of the last solve, which ages a kept factor.
  void note_solve();
  /// While a solve with the factor of this same K takes too many iterations: makes the factor more accurate and solves
  /// again.
  void improve_poor_factor(Vec q, Vec r, Vec y);
  /// Continues in the fallback sequence until K has a factor; returns false if only a smaller step is left.
  bool escalate(Vec q);

  /// Whether the factorization counts as many negative eigenvalues as the Hessian of a stable state has.
  bool has_right_inertia() const;
  /// The negative eigenvalues that it counts beyond those; nothing if it counts none.
  std::optional<PetscInt> unstable_modes() const;
  /// Whether a solution q, at which K was factorized, is stable apart from the places where barriers are: whether K has
  /// the right inertia there, or has it with projected barriers.
  bool is_stable(Vec q);
  /// Makes the factor more accurate; false if nothing better is available, or there is no factor.
  bool refine(Vec q);
  /// Sets the Krylov method for indefinite matrices, whatever the factorization has counted.
  void use_krylov_method_for_indefinite();
  /// Restores the Krylov method for definite matrices, which may have been replaced for indefinite ones.
  void use_usual_krylov_method();
  /// Forgets what was learned from earlier stages.
  void forget();

 private:
  FactorPolicy::Factor whose_factor() const {
    return escalation_.has_kept_factor() ? FactorPolicy::Factor::kept : FactorPolicy::Factor::own;
  }
  /// What becomes of a Hessian that is indefinite in single precision. `is_likely`: whether it is likely to be so in
  /// double precision too, which costs as much as several factorizations in single.
  Indefinite if_indefinite(bool is_likely) const;
  void factorize(Vec q, Indefinite indefinite = Indefinite::verified);
  /// Shifts the diagonal of K, factorized and indefinite, by the least amount that helps; false if none does.
  bool factorize_shifted(Vec q);
  /// Assembles the Hessian with projected barriers instead; false if it is indefinite.
  bool factorize_with_projected_walls(Vec q);
  /// Adds to the diagonal of K.
  void shift(double by);
  /// Solves a K that is symmetric but for its border by conjugate gradients from now on, or by GMRES.
  void take_as_symmetric(bool is_taken);
  /// Chooses one of these for a new factor: the oftener conjugate gradients were in vain, the later they are tried
  /// again.
  void choose_for_border();
  /// Solves by GMRES what conjugate gradients, if they were chosen for a border, have failed to solve.
  void solve_as_unsymmetric(Vec r, Vec y);
  /// Chooses conjugate gradients for a definite Hessian, GMRES otherwise.
  void choose_krylov_method();
  /// Number of negative eigenvalues of the Hessian with its rank-one terms, from the factorization of the current K.
  std::optional<PetscInt> negative_eigenvalues() const;
  PetscInt last_iterations() const;
  FactorPolicy::Solve last_solve() const;
  FactorPolicy::Factored what_is_factored() const;

  Objective& objective_;
  StageEquation& equation_;
  SolverStatistics& statistics_;
  KSP ksp_;
  Handle<Mat> K_;
  Handle<PC> preconditioner_;  // of K
  WorkVector diagonal_;
  std::vector<RankOne> parts_;                          // rank-one terms of the Hessian, in addition to K
  std::unique_ptr<RankOneSystem> rank_one_;             // nullptr if there are no such parts
  std::unique_ptr<NodalRotations> rotations_;           // since the factorization; nullptr if it does not rotate
  std::unique_ptr<CorotatedPreconditioner> corotated_;  // nullptr likewise
  SeveralSystems several_;
  std::vector<SeveralDoubles> turned_back_;
  std::unique_ptr<BorderedSystem> bordered_;  // nullptr if K has no border
  FactorPolicy factor_;
  Escalation escalation_;
  PetscBool krylov_is_chosen_ = PETSC_FALSE;  // by the user
  bool is_taken_as_symmetric_ = false;
  int num_in_vain_ = 0;        // factors in a row with which conjugate gradients failed
  int num_not_symmetric_ = 0;  // factors left before they are tried again
  PetscInt most_iterations_ = 0;
  bool may_choose_krylov_;  // the linear solver is conjugate gradients, and not by the user's choice
  bool projects_walls_ = false;
  Remedy remedy_ = Remedy::projected_walls;
  double last_shift_ = 0.0;  // of an indefinite Hessian, as a fraction of its mean diagonal
};

}  // namespace pliant
