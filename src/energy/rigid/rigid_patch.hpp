/// Rigid parts (RBE2): nodes that move as a rigid body whose rotation follows from the forces. There the configuration
/// is a nonlinear function of the unknowns (degrees of freedom).
#pragma once

#include "energy/given_motion.hpp"
#include "energy/rigid/affine_fit.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A rigid patch that rotates freely; its translation is free in the components that RigidMotion leaves free.
enum class FreeRotation { about_all_axes, about_axis };

/// Why the nodes do not determine a rotation, as words that follow their name; nothing if they do. Collective.
std::optional<std::string> why_not_rigid(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                         const RigidMotion& motion, FreeRotation rotation);
/// Whether the nodes lie in a plane that does not contain the motion's centre: accelerations do not determine its path
/// then. Collective.
bool centre_is_off_plane(const NodeLayout& layout, std::span<const PetscInt> nodes, const RigidMotion& motion);

/// The quantity of a patch that a stage keeps rigid.
enum class Rigidity {
  /// Its configuration: a potential stays a potential. For motions without inertia: the rates that follow from rigid
  /// configurations cost most methods their order.
  of_configurations,
  /// Its acceleration, and the configuration at the end of the step. In a stage configurations are affine, x = c + F r,
  /// and F obeys the second derivative of F^T F = I, F^T F'' + F''^T F + 2 F'^T F' = 0 with the rates of the stage.
  /// Together with the balance of forces and torques these are ordinary differential equations for x and v, of which
  /// every method keeps its order. Their drift is removed in the last stage, whose F is chosen so that the step ends
  /// rigid: neighbours follow, and no stress is left behind. The velocities are then rigid except for an error along
  /// the forces of the constraint, which is projected out (energy/constraint/velocity_projection.hpp). As these forces
  /// have neither resultant nor moment in any stage, implicit-midpoint keeps the momenta. Source: Hairer & Wanner,
  /// Solving Ordinary Differential Equations II, VII.2 (index reduction, projection); Hairer, Lubich & Wanner,
  /// Geometric Numerical Integration, VII.1 (RATTLE).
  of_accelerations
};

/// A rigid part (RBE2): nodes that move as a rigid body whose rotation follows from the forces. In a stage
///
///   x_a = X_a + d + D r_a + (exp(theta) R_ref - I) S r_a,   r_a = X_a - centre,
///
/// where R_ref is a rotation close to the stage's guess, so that theta stays small. With Rigidity::of_configurations D
/// = 0 and S = I; where the step's end E + w x must be rigid (StagePoint::end_weight), D = -grad E / w and S = I / w.
/// Otherwise, with F = F0 + dt F', F' = F0' + dt F'' and F0, F0' from the nodes at the stage's start, the equation
/// above reads (F - B)^T (F - B) = S^2, B = (3 F0 + dt F0') / 4, S^2 = B^T B - F0^T F0 / 2: F = B + R S, R a rotation.
///
/// The unknowns are the free components of d, and theta about three axes or one, times the patch's size; they replace
/// entries of the patch's first two nodes, and its other entries are slaves. All methods are collective unless they say
/// otherwise.
class RigidPatch {
 public:
  static constexpr std::size_t most_unknowns = 6;
  using Columns = std::array<Vector3<double>, most_unknowns>;

  /// `nodes`: owned ones, for which why_not_rigid returns nothing. `motion.angle` is not used.
  RigidPatch(const NodeLayout& layout, std::vector<PetscInt> nodes, const RigidMotion& motion, FreeRotation rotation);

  /// Owned nodes. Not collective.
  std::span<const PetscInt> nodes() const { return nodes_; }
  /// Entries that hold the unknowns, numbered over all ranks. Not collective.
  std::span<const PetscInt> hosts() const { return hosts_; }
  /// Whether nothing of the motion is prescribed. Not collective.
  bool is_free() const { return free_components_.size() == 3 && axes_.size() == 3; }

  /// Not collective.
  void set_rigidity(Rigidity rigidity) { rigidity_ = rigidity; }
  /// Sets the start of the stage to that of the prescribed components of d, so that their rates are exact (as for
  /// prescribed displacements, energy/constraint/prescribed.hpp).
  void start_stage(const StagePoint& stage) const;
  /// Begins a stage, from a guess q.
  void begin_stage(const StagePoint& stage, Vec q);

  /// As at the end of a step whose configuration is q: D = 0, S = I, theta = 0. Valid until the next begin_stage.
  void linearize_at(Vec q);

  /// The unknowns from their entries in y, on every rank.
  std::vector<double> unknowns(Vec y) const;
  /// The unknowns whose configuration is close to q, the closest one if q is rigid.
  std::vector<double> nearest_unknowns(Vec q) const;
  /// The rates of the unknowns at rest that are closest to the nodes' velocities.
  std::vector<double> nearest_rates(Vec v) const;
  /// Writes the unknowns to their entries of y. Not collective.
  void put_unknowns(std::span<const double> unknowns, Vec y) const;

  /// The displacement of the nodes in q. Not collective.
  void put_displacements(std::span<const double> unknowns, Vec q) const;
  /// dx_a / d(unknown k), for all k. Not collective.
  Columns columns(std::span<const double> unknowns, PetscInt node) const;
  /// The virtual displacements of the node with which forces and torques balance: the columns of the derivative if
  /// configurations are rigid, else rotations of the affine configuration. Not collective.
  Columns test_columns(std::span<const double> unknowns, PetscInt node) const;
  /// sum_a f_a . d t_ak / d(unknown l), t_ak the test columns, row k by row [N/m]; f: forces on the nodes.
  std::vector<double> curvature(std::span<const double> unknowns, Vec f) const;

  /// Removes the prescribed components of the centre's motion from nodal vectors.
  void subtract_given(Vec v) const;
  /// Replaces q and v by the closest rigid motion with the prescribed components of the translation at the time.
  void make_rigid(double time, double time_scale, Vec q, Vec v) const;
  /// Replaces v by the closest rigid motion at q, with the prescribed components just after the time.
  void make_velocities_rigid(double time, double time_scale, Vec q, Vec v) const;

 private:
  /// D and S.
  struct Shape {
    Tensor3<double> drift{}, arms = identity<double>();
    double weight = 1.0;  // of S, about
  };
  Shape shape_of(const StagePoint& stage) const;
  Quaternion nearest_rotation(const Tensor3<double>& gradient) const;
  Placement placement(std::span<const double> unknowns) const;
  Vector3<double> rotation_vector(std::span<const double> unknowns) const;
  Vector3<double> arm(PetscInt node) const { return layout_->position(node) - motion_.rigid->centre; }
  Placement nearest(Vec q) const;
  struct RigidState {
    Placement at;
    Vector3<double> velocity{}, omega{};  // of the centre, and the angular one
  };
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
  Vector3<double> given_translation_{};
  Shape shape_;
  Quaternion reference_{1.0, 0.0, 0.0, 0.0};
};

}  // namespace pliant
