/// Rigid parts (RBE2, kinematic coupling): nodes that move as a rigid body whose rotation follows from the forces.
#pragma once

#include "energy/constraint/dependent_nodes.hpp"
#include "energy/given_motion.hpp"
#include "energy/rigid/affine_fit.hpp"
#include "energy/rigid/joint_equation.hpp"
#include "fem/layout.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// The axes about which a rigid part rotates freely: all (free), or one (hinged). Its translation is free in the
/// components that RigidMotion leaves free.
enum class FreeRotation { about_all_axes, about_axis };

/// Why the nodes do not determine a rotation, as words that follow their name; nothing if they do. Collective.
std::optional<std::string> why_not_rigid(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                         const RigidMotion& motion, FreeRotation rotation);
/// Whether the nodes lie in a plane that does not contain the motion's centre: accelerations do not determine its path
/// then. Collective.
bool centre_is_off_plane(const NodeLayout& layout, std::span<const PetscInt> nodes, const RigidMotion& motion);

/// A rigid part (RBE2): nodes that move as a rigid body whose rotation follows from the forces. In a stage
///
///   x_a = X_a + d + D r_a + (exp(theta) R_ref - I) S r_a,   r_a = X_a - centre,
///
/// where R_ref is a rotation close to the stage's guess, so that theta stays small.
///
/// With Rigidity::of_configurations D = 0 and S = I.
///
/// With Rigidity::of_accelerations what is rigid is the acceleration, and the configuration at the end of the step. In
/// a stage configurations are affine, x = c + F r, and F fulfils the second derivative of F^T F = I,
///
///   F^T F'' + F''^T F + 2 F'^T F' = 0,   F = F0 + dt F',   F' = F0' + dt F'',
///
/// with F0 and F0' from the nodes at the stage's start. This is (F - B)^T (F - B) = S^2, B = (3 F0 + dt F0') / 4, S^2 =
/// B^T B - F0^T F0 / 2: F = B + R S, R a rotation. Together with the balance of forces and torques these are ordinary
/// differential equations for x and v, whose order every method keeps. Their drift is removed in the last stage, where
/// D = -grad E / w and S = I / w make the step's end E + w x rigid (StagePoint::end_weight): neighbours follow, and no
/// stress remains. The velocities are then rigid except for an error along the forces of the constraint, which is
/// projected out (energy/constraint/velocity_projection.hpp). As these forces have neither resultant nor moment in any
/// stage, implicit-midpoint keeps the momenta. Source: Hairer & Wanner, Solving Ordinary Differential Equations II,
/// VII.2 (index reduction, projection); Hairer, Lubich & Wanner, Geometric Numerical Integration, VII.1 (RATTLE).
///
/// The unknowns are the free components of d, and theta about three axes or one, times the part's size. Their hosts are
/// entries of the part's first two nodes.
class RigidPart final : public DependentNodes {
 public:
  /// `nodes`: owned ones, for which why_not_rigid returns nothing. `motion.angle` is not used. Collective.
  RigidPart(const NodeLayout& layout, std::vector<PetscInt> nodes, const RigidMotion& motion, FreeRotation rotation);

  std::string description() const override { return "rigid parts that turn freely"; }
  std::span<const PetscInt> nodes() const override { return nodes_; }
  std::span<const PetscInt> hosts() const override { return hosts_; }
  void set_rigidity(Rigidity rigidity) override { rigidity_ = rigidity; }
  bool is_symmetric() const override { return rigidity_ == Rigidity::of_configurations; }

  void begin_stage(const StagePoint& stage, Vec q) override;
  void set_prescribed_fraction(double fraction) override;
  /// D = 0, S = I, R_ref the rotation of q.
  void begin_end_of_step(Vec q) override;

  void put_displacements(std::span<const double> unknowns, Vec q) const override;
  void put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const override;
  /// With Rigidity::of_accelerations: translations, and rotations of the affine configuration.
  void put_test_columns(std::span<const double> unknowns, PetscInt node,
                        std::span<Vector3<double>> columns) const override;
  std::vector<double> curvature(std::span<const double> unknowns, Vec f) const override;

  double rotation(std::span<const double> unknowns) const override { return norm(rotation_vector(unknowns)); }
  double rotation_by(std::span<const double> step, std::span<const double> /*unknowns*/) const override {
    return rotation(step);
  }
  std::vector<double> nearest_unknowns(Vec q) const override;
  std::vector<double> nearest_rates(Vec v) const override;

  /// The prescribed components of the translation are treated as prescribed displacements are
  /// (energy/constraint/prescribed.hpp).
  void start_stage(const StagePoint& stage) const override;
  void complete_step(const Step& step, Vec q, Vec v) const override;
  void restart(const Step& step, Vec q, Vec v) const override;
  void subtract_given(Vec v) const override;
  std::vector<const RigidPart*> parts() const override {
    return is_symmetric() ? std::vector<const RigidPart*>{} : std::vector<const RigidPart*>{this};
  }
  std::vector<BodyMotion<double>> allowed_velocities(std::size_t /*part*/) const override {
    return at(std::vector<double>(hosts_.size(), 0.0)).columns;
  }

  /// What joints need of a part whose nodes do not lie in a plane (energy/constraint/mechanism.hpp).

  /// The affine motion nearest to u. Collective.
  BodyMotion<double> motion_of(Vec u) const;
  /// The motion in the stage, with its columns.
  PartMotion motion(std::span<const double> unknowns) const;
  /// The virtual motion of unknown k: at the end of a step its rate.
  BodyMotion<double> virtual_motion(std::size_t k, const BodyMotion<double>& at) const;
  /// The derivative of each virtual motion k by each unknown l, at k n + l of n unknowns. `columns`: at the unknowns.
  std::vector<BodyMotion<double>> bends(std::span<const double> unknowns,
                                        std::span<const BodyMotion<double>> columns) const;
  /// The force on the motion of the part, from those on the entries of this rank's nodes [N].
  MotionForce force_on_motion(std::span<const double> forces) const;
  /// Placement and velocities, as seen from the centre; nearest to q and v. Collective.
  struct RigidState {
    Placement at;
    Vector3<double> velocity{}, omega{};
    Vector3<double> centre{};

    BodyMotion<double> motion() const;
    BodyMotion<double> rate() const;
  };
  RigidState state(const Step& step, Side side, Vec q, Vec v) const;
  /// Whether a formula of time moves it. Not collective.
  bool is_moved() const { return motion_.rigid->depends_on_time(); }
  /// No component of the translation is given, or it is 0 for good.
  bool is_ideal() const override {
    return std::ranges::all_of(motion_.rigid->translation, [](const std::optional<Expression>& given) {
      return !given || (given->is_zero() && !given->is_replaceable());
    });
  }
  /// The same without what is prescribed: as it is. Collective.
  RigidState state(Vec q, Vec v) const;
  /// Moves a state by unknowns, and changes its velocities by rates of them.
  RigidState moved(RigidState state, std::span<const double> unknowns, std::span<const double> rates) const;
  /// Writes displacements (unless q is nullptr) and velocities of a state to the nodes.
  void put(const RigidState& state, Vec q, Vec v) const;
  /// The distance of the nodes from their mean, about [m].
  double size() const { return size_; }
  /// Whether the nodes lie in a plane.
  bool is_plane() const { return trace(fit_->in_plane()) < 2.5; }
  Vector3<double> reference(PetscInt node) const { return layout_->position(node); }

 private:
  static constexpr std::size_t most_unknowns = 6;
  /// Whether nothing of the motion is prescribed.
  bool is_free() const { return free_components_.size() == 3 && axes_.size() == 3; }
  /// D and S.
  struct Shape {
    Tensor3<double> drift{}, arms = identity<double>();
    double weight = 1.0;  // of S, about
  };
  Shape shape_of(const StagePoint& stage) const;
  Quaternion nearest_rotation(const Tensor3<double>& gradient) const;
  Placement placement(std::span<const double> unknowns) const;
  Vector3<double> rotation_vector(std::span<const double> unknowns) const;
  template <class T>
  BodyMotion<T> motion_of_unknowns(std::span<const T> unknowns) const;
  BodyMotion<double> second_derivative(std::span<const double> unknowns, std::size_t k, std::size_t l) const;
  /// The motion at the unknowns, kept for the next call.
  const PartMotion& at(std::span<const double> unknowns) const;
  GivenKinematics given_at(const StagePoint& stage) const;
  Vector3<double> arm(PetscInt node) const { return layout_->position(node) - motion_.rigid->centre; }
  Placement nearest(Vec q) const;
  RigidState nearest_state(const GivenKinematics& given, Vec q, Vec v) const;
  /// The velocity of the centre and the angular velocity closest to the nodes' velocities at a placement.
  std::array<Vector3<double>, 2> nearest_velocities(const Placement& placement, Vec v) const;

  const NodeLayout* layout_;
  std::vector<PetscInt> nodes_;
  GivenDisplacement motion_;
  std::vector<std::size_t> free_components_;  // of the translation
  std::vector<Vector3<double>> axes_;
  double size_ = 1.0;  // [m]
  std::vector<PetscInt> hosts_;
  std::optional<AffineFit> fit_;
  Rigidity rigidity_ = Rigidity::of_configurations;
  // State of the current stage.
  Vector3<double> given_translation_{}, start_translation_{}, end_translation_{};  // start_: of the accepted state
  Shape shape_;
  Quaternion reference_{1.0, 0.0, 0.0, 0.0};
  mutable std::vector<double> at_unknowns_;
  mutable PartMotion at_;  // at these; without columns: nowhere yet
};

}  // namespace pliant
