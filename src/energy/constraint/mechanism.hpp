/// Rigid parts that joints connect, as one function of as many unknowns as the mechanism has degrees of freedom.
#pragma once

#include "energy/constraint/rigid_part.hpp"
#include "energy/rigid/joint_bearing.hpp"
#include "energy/rigid/joint_system.hpp"

#include <algorithm>
#include <eigen3/Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// Rigid parts and joints between them, closed loops included. With the unknowns xi of all parts (RigidPart), the
/// equations of the joints are h(xi) = 0: those of the configuration, or, with Rigidity::of_accelerations, those of the
/// acceleration in all stages but the last, d2g/dt2 = 0 with the rates (x - x0) / dt and (x - x0 - dt v0) / dt^2, and
/// g = 0 for the step's end in the last (so that the order of every method is kept, as a rigid part keeps it). The
/// unknowns y are coordinates of the solutions of these equations (tangent-plane parametrisation),
///
///   xi(y) = xi_ref + N y + D G_ref^T z(y),   h(xi(y)) = 0,   G = dh/dxi,   G_ref N = 0,   N^T N = I,
///
/// N as close as possible to the same columns at all times, so that the factors of matrices can be kept. z is found by
/// Newton's method to rounding: joints are exact whatever the solver's tolerance. D is the identity, but for parts that
/// soft bodies hold: there it is small, so that the parts which hang from them turn by finite angles without a reaction
/// on a stiff body (else the energy is a narrow curved valley). The virtual displacements are those
/// which the joints allow at the configuration of the stage: their forces on two bodies are opposite, with no resultant
/// and no moment. Sources: Potra & Yen 1991, "Implicit numerical integration for Euler-Lagrange equations via tangent
/// space parametrization"; Hairer & Wanner, Solving Ordinary Differential Equations II, VII.2.
class Mechanism final : public DependentNodes {
 public:
  /// `parts`: their nodes do not lie in planes. `are_held`: one flag each, whether soft bodies hold it. `equations`:
  /// independent at the reference configuration (dependent_joints). Collective.
  Mechanism(const NodeLayout& layout, std::vector<std::unique_ptr<RigidPart>> parts, const std::vector<char>& are_held,
            std::vector<JointEquation> equations);

  /// JointSystem::dependent_joints, at the reference configuration. Not collective.
  JointSystem::Dependent dependent_joints() const { return joints_.dependent_joints(G_ref_); }
  /// The size of the largest part [m].
  double size() const { return size_; }
  std::size_t num_degrees_of_freedom() const { return hosts_.size(); }
  /// The motions that the joints leave near the reference configuration, where it is moved along free_motions() by
  /// these numbers [m]; nothing if the joints are not found to allow that. Before the first stage. Collective.
  std::optional<JointSystem::Matrix> free_motions_near(const JointSystem::Vector& moved) const;
  /// The motions that the joints leave at the reference configuration: orthonormal columns in the unknowns of all
  /// parts.
  const JointSystem::Matrix& free_motions() const { return preferred_; }

  std::string description() const override { return "mechanisms"; }
  std::span<const PetscInt> nodes() const override { return nodes_; }
  std::span<const PetscInt> hosts() const override { return hosts_; }
  void set_rigidity(Rigidity rigidity) override;
  bool is_symmetric() const override { return rigidity_ == Rigidity::of_configurations; }

  void begin_stage(const StagePoint& stage, Vec q) override;
  void set_prescribed_fraction(double fraction) override;
  void begin_end_of_step(Vec q) override;

  void put_displacements(std::span<const double> unknowns, Vec q) const override;
  void put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const override;
  void put_test_columns(std::span<const double> unknowns, PetscInt node,
                        std::span<Vector3<double>> columns) const override;
  std::vector<double> curvature(std::span<const double> unknowns, Vec f) const override;

  double rotation(std::span<const double> unknowns) const override { return largest_rotation(at(unknowns).xi); }
  double rotation_by(std::span<const double> step, std::span<const double> unknowns) const override;
  std::vector<double> nearest_unknowns(Vec q) const override;
  std::vector<double> nearest_rates(Vec v) const override;

  void start_stage(const StagePoint& stage) const override;
  void complete_step(const Step& step, Vec q, Vec v) const override;
  void restart(const Step& step, Vec q, Vec v) const override;
  void subtract_given(Vec v) const override;
  std::vector<const RigidPart*> parts() const override;
  std::vector<BodyMotion<double>> allowed_velocities(std::size_t part) const override;

  bool is_driven() const override {
    return joints_.is_driven() || std::ranges::any_of(parts_, [](const auto& part) { return part->is_moved(); });
  }
  bool is_ideal() const override {
    return !joints_.is_driven() && std::ranges::all_of(parts_, [](const auto& part) { return part->is_ideal(); });
  }
  bool refreezes() const override { return !bearings_.empty(); }
  void refreeze(std::span<const double> unknowns, Vec r) override;
  /// The largest effort of friction in a bearing, from the load that it carries in a stage (StageEquation::refreeze).
  std::shared_ptr<const double> follow(const JointBearing& bearing) { return bearings_.add(bearing); }

  /// The states of two of the parts (JointEquation::ground: at rest) that are nearest to q and v. Collective.
  std::array<RigidPart::RigidState, 2> states(const std::array<int, 2>& parts, Vec q, Vec v) const;
  /// How far a state at a step's start is from what a joint allows; zero where rounding of an input explains it.
  struct Violation {
    double distance = 0.0;  ///< [m]; of rotations about the arm of the bodies
    double speed = 0.0;     ///< likewise, of what no formula of time prescribes [m/s]
  };
  /// Those of all joints, of the states of the parts nearest to q and v. Collective.
  std::vector<Violation> violations(const Step& step, Vec q, Vec v) const;
  /// The reactions of the joints, from the gradient r of the potential at q, where nothing else holds the bodies.
  /// `points`: of the joints, in the reference configuration [m]. Collective.
  std::vector<JointReaction> reactions(Vec r, Vec q, std::span<const Vector3<double>> points) const;

 private:
  using Vector = JointSystem::Vector;
  using Matrix = JointSystem::Matrix;
  using Along = JointSystem::Along;
  /// A solution of the joints' equations and its derivatives.
  struct Solution {
    std::vector<double> unknowns;
    Vector xi;
    std::vector<PartMotion> parts;
    Matrix columns, test_columns;                                           // d xi / dy, and virtual displacements
    std::vector<std::vector<BodyMotion<double>>> motions, virtual_motions;  // the same, of each part by each unknown
    JointFactors test;  // of G_W D G_ref^T, G_W: along virtual displacements
  };

  std::span<const double> of_part(const Vector& xi, std::size_t part) const;
  std::vector<PartMotion> motions(const Vector& xi) const;
  /// The unknowns of each part that are nearest to q.
  Vector nearest_of_parts(Vec q) const;
  /// h and its derivative by xi.
  void evaluate(const std::vector<PartMotion>& parts, Vector& h, JointDerivative& G) const;
  /// The same where all of what is prescribed has happened.
  void evaluate_all(const std::vector<PartMotion>& parts, Vector& h, JointDerivative& G) const;
  /// The columns N for equations with the derivative G_ref.
  void choose_columns();
  /// Turns the columns such that the last of them do not move parts which soft bodies hold.
  void separate_held_parts();
  /// The part of the preferred columns in the null space of G_ref.
  Matrix preferred_in_null_space() const;
  /// D G_ref^T z.
  Matrix across(const Matrix& z) const { return weights_.asDiagonal() * G_ref_.transposed_times(z); }
  /// y of xi_ref + change, of which z is what is left.
  std::vector<double> coordinates(const Vector& change) const;
  double largest_rotation(const Vector& xi) const;
  /// The nearest solution of h(xi) = 0 about; false: none is found.
  bool approach(Vector& xi) const;
  /// Newton's method for h(start + D G_ref^T z) = 0, with the motions and G at its end; false: it does not converge.
  bool solve(Vector& xi, std::vector<PartMotion>& parts, JointDerivative& G) const;
  const Solution& at(std::span<const double> unknowns) const;
  /// The motions of the parts by the mechanism's unknowns, from those by the parts' own.
  void combine(Solution& solution) const;
  /// States of the parts, nearest to q and v.
  std::vector<RigidPart::RigidState> states(const Step& step, Side side, Vec q, Vec v) const;
  /// Those of which velocities, and configurations too, fulfil the joints' equations; whether they are new.
  bool fit_states(const Step& step, Side side, bool with_configurations,
                  std::vector<RigidPart::RigidState>& states) const;
  std::vector<PartMotion> motions(const std::vector<RigidPart::RigidState>& states) const;

  MPI_Comm comm_;
  std::vector<std::unique_ptr<RigidPart>> parts_;
  std::vector<std::size_t> first_;  // unknown of each part, and their number
  JointSystem joints_;
  JointBearings bearings_;
  double size_ = 0.0;  // of the parts [m]
  std::vector<PetscInt> nodes_, hosts_;
  std::vector<std::size_t> part_of_node_;  // per local owned node
  Vector weights_;                         // D
  Matrix preferred_;                       // columns N at the start of the run
  Eigen::Index num_alone_ = 0;             // those of them that do not move held parts, the last ones
  Rigidity rigidity_ = Rigidity::of_configurations;
  // State of the current stage.
  enum class Level { configuration, acceleration, end_of_step };
  Level level_ = Level::configuration;
  double end_weight_ = 1.0;
  std::vector<BodyMotion<double>> start_, advance_, rest_;  // x0, dt v0, and the rest of the step's end
  JointSystem::Given given_;
  Vector violation_;  // h at the accepted state; empty: unknown
  double lag_ = 0.0;  // the part of it that is to be left: 1 - the fraction of what is prescribed
  Vector reference_;
  Matrix columns_;  // N
  JointDerivative G_ref_;
  mutable Solution solution_;
};

}  // namespace pliant
