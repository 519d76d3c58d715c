/// The equation of a stage in the unknowns that constraints leave.
#pragma once

#include "energy/constraint/beside_identity.hpp"
#include "energy/constraint/constraint_map.hpp"
#include "energy/equation/constrained_product.hpp"
#include "energy/stage_equation.hpp"
#include "petsc/leading_part.hpp"
#include "petsc/matrix_pattern.hpp"

#include <array>
#include <optional>

namespace pliant {

/// Phi(T(y)) and its derivatives, T the map of the constraints with the Jacobian J: J^T r and J^T K J + sum_i r_i
/// d2T_i/dy2 (the second part not where the Hessian is to be positive semidefinite, as its first is then). What belongs
/// to a potential stays one, and Newton's method on it converges quadratically. Where the map balances forces by other
/// virtual displacements W than J (ConstraintMap::is_symmetric), these are W^T r and W^T K J + sum_i r_i dW_i/dy, of no
/// potential. Entries of slaves are as prescribed ones: their rows of the gradient are zero, those of the Hessian hold
/// the diagonal alone. Unknowns of the equation in addition to displacements (pressures) are those of this one too: T,
/// J and W leave them as they are.
class ConstrainedEquation final : public StageEquation {
 public:
  /// Both outlive the object; the map's rigidity is set. Collective.
  ConstrainedEquation(StageEquation& equation, ConstraintMap& map);

  /// The extrapolation by dt v0 from the start of the stage that is returned is that of the configurations.
  StagePoint enter(const StagePoint& stage, Vec q, Vec y) override;
  void leave(Vec y, Vec q) override;
  void give_up() override;
  void forget() override;
  void freeze(Vec y) override;
  bool refreeze(Vec y) override;
  bool exceeds_bound() const override { return equation_.exceeds_bound(); }
  void exceed_bound() override;
  void drag(Vec y, Vec at, Vec f) override;
  double value(Vec y) override;
  void gradient(Vec y, Vec r) override;
  Handle<Mat> make_hessian() const override;
  /// `K` comes from make_hessian.
  void hessian(Vec y, Mat K, Projection projection) override;
  void follow_rigid_motions(Vec y, Mat K) const override;
  std::unique_ptr<NodalRotations> make_rotations() const override;
  Vec displacements(Vec y) override;
  std::size_t num_rank_one() const override { return equation_.num_rank_one(); }
  void rank_one_parts(Vec y, std::vector<RankOne>& parts) override;
  double max_step(Vec y, Vec d) override;
  bool has_walls() const override { return equation_.has_walls(); }
  double max_step_to_wall(Vec y, Vec d, Walls which) override;
  void extrapolate_from(Vec y) override;
  bool is_static() const override { return equation_.is_static(); }
  bool follow_obstacles(Followers which, Vec y) override;
  bool follow_prescribed_nodes(Vec y) override;
  bool is_far_from_guess(Vec y) override;
  void set_prescribed_fraction(double fraction) override;
  double force_scale(Vec y) override;
  double inertia_scale() override { return equation_.inertia_scale(); }
  double rounding_floor(Vec y) const override;
  void size_of_diagonal(Mat K, Vec D) const override;
  PetscInt num_negative_pivots() const override { return equation_.num_negative_pivots(); }
  std::vector<std::string> non_potentials() const override;
  Symmetry symmetry() const override { return symmetry_; }
  std::vector<PetscInt> border() const override;
  const std::vector<char>& prescribed() const override { return prescribed_; }
  PetscInt num_unknowns() const override { return equation_.num_unknowns(); }
  MPI_Comm comm() const override { return equation_.comm(); }
  Handle<Vec> make_vector() const override { return equation_.make_vector(); }

 private:
  /// x = T(y), the unknowns of the equation that is constrained.
  void expand(Vec y, Vec x) const;
  /// y = the unknowns whose configuration is near that of x.
  void restrict(Vec x, Vec y) const;
  /// The same for rates at rest.
  void restrict_rates(Vec x, Vec y) const;
  /// Brings J and W to y.
  void linearize(Vec y);
  /// x_ = T(y) and d_ = J d, there, with the rest of what is prescribed.
  void expand_direction(Vec y, Vec d);
  /// A gradient in x, which is known until something else changes than y.
  struct KnownGradient {
    Handle<Vec> y, r;
    bool is_known = false;
  };
  /// The gradient of the equation at T(y), by evaluation unless it is one of the last two.
  Vec gradient_in_x(Vec y);
  void forget_gradients();
  /// ConstraintMap::refreeze, with a gradient r in x.
  void refreeze_map(Vec y, Vec r);
  Mat test_matrix() const { return (own_test_matrix_ ? *own_test_matrix_ : jacobian_).matrix(); }
  void set_near_null_space(Mat K) const;
  /// For the present pattern of the Hessian in x.
  void make_product();
  /// K = W^T (Hessian in x) J.
  void project(Mat K);
  Symmetry find_symmetry() const;

  StageEquation& equation_;
  ConstraintMap& map_;
  std::vector<char> prescribed_;  // those of the equation, and slaves
  BesideIdentity jacobian_;
  std::optional<BesideIdentity> own_test_matrix_;  // where W is not J
  Handle<Mat> full_;                               // Hessian in x
  std::optional<ConstrainedProduct> product_;      // W^T K J
  Symmetry symmetry_ = Symmetry::symmetric;
  PetscObjectId pattern_of_full_ = 0;  // pattern_id
  PresentPattern present_pattern_;     // of W^T K J
  LeadingPart y_part_, x_part_;
  double fraction_ = 1.0;  // of what is prescribed
  Handle<Vec> x_, d_, full_gradient_, y0_, w0_, accepted_;
  Handle<Vec> start_;  // x where the stage begins, from which dependent nodes are turned
  std::array<KnownGradient, 2> known_;
  std::size_t last_known_ = 0;
};

}  // namespace pliant
