/// The incremental potential of a stage: the sum of its terms over all ranks, with prescribed entries eliminated.
#pragma once

#include "energy/equation/energy_accounts.hpp"
#include "energy/equation/stage_adjoint.hpp"
#include "energy/equation/stage_terms.hpp"
#include "energy/stage_equation.hpp"
#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"
#include "petsc/matrix_parts.hpp"
#include "petsc/matrix_pattern.hpp"
#include "time/stage.hpp"

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace pliant {

/// Phi(q) = sum of terms(q); docs/theory.md, "The incremental potential". Works on vectors of make_vector(layout).
class IncrementalPotential final : public StageEquation {
 public:
  /// `prescribed`: one flag per local entry. The references and terms outlive the object.
  IncrementalPotential(const NodeLayout& layout, const BlockPattern& pattern, std::vector<const EnergyTerm*> terms,
                       const std::vector<char>& prescribed);

  std::span<const EnergyTerm* const> terms() const { return terms_.all(); }

  /// Begins the stage to which all following calls refer.
  void begin_stage(const StagePoint& stage);
  StagePoint enter(const StagePoint& stage, Vec q, Vec xi) override;
  void freeze(Vec q) override;
  bool refreeze(Vec q) override;
  bool exceeds_bound() const override { return exceeds_bound_; }
  void exceed_bound() override;
  void drag(Vec q, Vec at, Vec f) override;

  /// Phi(q) [J] up to a constant of the stage; +inf where a barrier is crossed or a number is not finite.
  double value(Vec q) override;
  /// r = dPhi/dq [N], zero on prescribed entries.
  void gradient(Vec q, Vec r) override;
  /// Likewise, with the reactions (forces that hold them) in the prescribed entries.
  void gradient_with_reactions(Vec q, Vec r);
  /// The sum of the gradients of some terms.
  void gradient_of(const std::function<bool(const EnergyTerm&)>& wanted, Vec q, Vec r);
  /// What the terms do in the stage, for ledgers and results. Refers to this object. Not collective.
  EnergyAccounts accounts() { return EnergyAccounts(terms_); }
  /// The transposed derivatives of the stage. Refers to this object. Not collective.
  StageAdjoint adjoint() { return StageAdjoint(terms_); }
  /// A zero matrix for the Hessian, with the rigid-body modes as its near-null space.
  Handle<Mat> make_hessian() const override;
  std::optional<Coarsening> make_coarsening() const override;
  std::unique_ptr<NodalRotations> make_rotations() const override;
  /// K = d2Phi/dq2 [N/m]; rows and columns of prescribed entries are zero except for the diagonal.
  void hessian(Vec q, Mat K, Projection projection) override;
  void extrapolate_from(Vec q) override { terms_.arrays().extrapolate_from(q); }
  bool is_static() const override;
  void follow_rigid_motions(Vec q, Mat K) const override;
  std::size_t num_rank_one() const override { return terms_.functions_of_sum().size(); }
  void rank_one_parts(Vec q, std::vector<RankOne>& parts) override;
  bool move_rigidly(Vec q) override;
  bool follow_obstacles(Followers which, Vec q) override;
  bool follow_prescribed_nodes(Vec q) override;
  void forget() override;
  /// The largest alpha for which q + alpha d stays clear of all barriers; less where d is too long to look for all
  /// pairs on the way (StageArrays::along).
  double max_step(Vec q, Vec d) override;
  bool has_walls() const override;
  double max_step_to_wall(Vec q, Vec d, Walls which) override;
  /// Sum over the terms of the norms of their gradients [N]: the size of the forces that must balance. Prescribed
  /// entries count, because reactions balance too: a body under uniform stress has no other forces.
  double force_scale(Vec q) override;
  double inertia_scale() override;
  /// Size of the rounding errors in the gradient at q [N]: |eps K_ii u_i| with the diagonal of the last Hessian, and
  /// eps c |g| sum |g_i u_i| with its rank-one terms.
  double rounding_floor(Vec q) const override;
  /// Size of the energy of displacements that are rounding errors of places and of q [J]: 1/2 sum K_ii (eps (|X_i| +
  /// |u_i|))^2 with the same diagonal, which has the masses of a stage, too. Collective.
  double rounding_energy(Vec q) const;
  void size_of_diagonal(Mat /*K*/, Vec D) const override { check(VecCopy(diagonal_.get(), D)); }

  std::vector<std::string> non_potentials() const override;
  Symmetry symmetry() const override;
  const std::vector<char>& prescribed() const override { return prescribed_; }
  PetscInt num_unknowns() const override { return 3 * layout_.num_global_nodes; }
  MPI_Comm comm() const override { return layout_.comm; }
  Handle<Vec> make_vector() const override { return pliant::make_vector(layout_); }

  /// A vector for the internal variables of all terms, zero; nullptr if there are none.
  Handle<Vec> make_internal() const;
  /// The hooks of the time layer; they refer to this object.
  InternalVariables internal_variables();

 private:
  /// A zero matrix of a pattern, with the properties of the Hessian.
  Handle<Mat> make_hessian_of(const BlockPattern& pattern) const;
  /// Gives K the pattern of cells and pairs, unless it already has it. Collective.
  void fit(Mat K);
  /// r = the rows of owned nodes.
  void take_owned(std::span<const double> rows, Vec r) const;
  /// Whether coefficients frozen at the step's start do more than those of q allow (EnergyTerm::bound).
  bool exceeds_a_bound(Vec q);
  void clear_prescribed(std::span<double> r) const;
  /// Norm of the term's forces at q, whose ghosts are up to date.
  double force_of(std::size_t k, std::span<const double> q);
  /// How far term k lets go along the path of StageArrays::along: where it couples pairs, not beyond the path's end.
  double step_bound(std::size_t k, const Path& path);

  const NodeLayout& layout_;
  const BlockPattern& pattern_;
  std::vector<char> prescribed_;
  RowElimination elimination_;
  StageTerms terms_;
  bool exceeds_bound_ = false;                      // of the stage that was last solved
  double sum_rounding_ = 0.0;                       // of the last rank-one terms [N]
  std::vector<std::vector<PetscInt>> free_bodies_;  // owned nodes of each body that nothing holds
  Handle<Vec> work_, diagonal_;                     // that of the last Hessian
  // Where terms couple pairs.
  Handle<Mat> of_cells_;  // the part of the Hessian that has the pattern of the cells
  PresentPattern present_pattern_;
};

}  // namespace pliant
