/// Nodes whose displacements are a nonlinear function of a few unknowns (degrees of freedom): a kinematic coupling.
#pragma once

#include "base/vector3.hpp"
#include "energy/rigid/joint_equation.hpp"
#include "time/stage.hpp"

#include <span>
#include <string>
#include <vector>

#include <petscvec.h>

namespace pliant {

class RigidPart;

/// The quantity that a stage keeps rigid.
enum class Rigidity {
  /// Its configuration: a potential stays a potential. For motions without inertia: the rates that follow from rigid
  /// configurations cost most methods their order.
  of_configurations,
  /// Its acceleration, and the configuration at the end of the step (energy/constraint/rigid_part.hpp).
  of_accelerations
};

/// Nodes whose displacements are a nonlinear function of a few unknowns x_k [m],
///
///   q_a = Q_a(x),   columns t_ak = dQ_a/dx_k [1],   curvature c_kl = sum_a f_a . dt_ak/dx_l [N/m],
///
/// such as a rigid part: a body's pose, or the coordinate of a joint, from which the nodes follow. ConstraintMap
/// combines them with the other constraints. The unknowns take the places of entries of the nodes (`hosts`). Forces
/// balance along the virtual displacements w_ak, which are equal to t_ak unless accelerations are kept rigid. State
/// lasts for a stage: nothing has to be kept in a checkpoint. Vectors have the layout of q; all methods are collective
/// unless they say otherwise.
class DependentNodes {
 public:
  virtual ~DependentNodes() = default;

  /// What they are, as a plural in a message. Not collective.
  virtual std::string description() const = 0;
  /// Owned nodes. Not collective.
  virtual std::span<const PetscInt> nodes() const = 0;
  /// Entries that hold the unknowns, numbered over all ranks; the same on every rank. Not collective.
  virtual std::span<const PetscInt> hosts() const = 0;

  /// To be called before the first stage. Not collective.
  virtual void set_rigidity(Rigidity rigidity) = 0;
  /// Whether w_ak = t_ak, so that a potential of q is one of x. Not collective.
  virtual bool is_symmetric() const = 0;

  /// Begins a stage, to which all following calls refer; q: a guess of its end. The function may be chosen such that
  /// the unknowns stay small.
  virtual void begin_stage(const StagePoint& stage, Vec q) = 0;
  /// Sets what formulas prescribe to a fraction between the accepted state (0; StagePoint::accepted) and the end of the
  /// stage (1), where it is after `begin_stage`. Not collective.
  virtual void set_prescribed_fraction(double /*fraction*/) {}
  /// Makes the columns at unknowns of zero those of the velocities that are allowed at the end of a step whose
  /// configuration is q. Valid until the next begin_stage.
  virtual void begin_end_of_step(Vec q) = 0;

  /// Writes Q_a(x) to the entries of the nodes. Not collective.
  virtual void put_displacements(std::span<const double> unknowns, Vec q) const = 0;
  /// columns[k] = t_ak of a node. Not collective.
  virtual void put_columns(std::span<const double> unknowns, PetscInt node,
                           std::span<Vector3<double>> columns) const = 0;
  /// columns[k] = w_ak of a node. Not collective.
  virtual void put_test_columns(std::span<const double> unknowns, PetscInt node,
                                std::span<Vector3<double>> columns) const = 0;
  /// sum_a f_a . dw_ak/dx_l over the owned nodes, row k by row; f: forces on q. Not collective.
  virtual std::vector<double> curvature(std::span<const double> unknowns, Vec f) const = 0;

  /// The largest angle by which a body has rotated since `begin_stage` [rad]. At 2 pi forces seem to be balanced that
  /// are not: rotation vectors of this length are the same rotation. Not collective.
  virtual double rotation(std::span<const double> /*unknowns*/) const { return 0.0; }
  /// The angle of a step of the unknowns, to first order.
  virtual double rotation_by(std::span<const double> /*step*/, std::span<const double> /*unknowns*/) const {
    return 0.0;
  }
  /// The unknowns whose configuration is close to q, the closest one if that fulfils the constraint.
  virtual std::vector<double> nearest_unknowns(Vec q) const = 0;
  /// The rates of the unknowns at rest whose velocities are closest to v.
  virtual std::vector<double> nearest_rates(Vec v) const = 0;

  /// Sets the start of the stage (StagePoint::q0, v0) such that the rates of what is prescribed are exact.
  virtual void start_stage(const StagePoint& stage) const = 0;
  /// Replaces q and v by the closest ones that fulfil the constraint at the end of the step.
  virtual void complete_step(const Step& step, Vec q, Vec v) const = 0;
  /// Replaces v by the closest velocities that fulfil the constraint at q, with what is prescribed just after the time.
  virtual void restart(const Step& step, Vec q, Vec v) const = 0;
  /// The rigid parts whose accelerations are kept rigid; none where is_symmetric(). Not collective.
  virtual std::vector<const RigidPart*> parts() const { return {}; }
  /// After begin_end_of_step: the velocities of one of these parts that are allowed, by each unknown. Not collective.
  virtual std::vector<BodyMotion<double>> allowed_velocities(std::size_t /*part*/) const { return {}; }
  /// Whether terms depend on forces of the constraint that are frozen (StageEquation::refreeze). Not collective.
  virtual bool refreezes() const { return false; }
  /// Freezes them at what they are at the unknowns, where the gradient of the potential is r; no r: at zero.
  virtual void refreeze(std::span<const double> /*unknowns*/, Vec /*r*/) {}
  /// Whether formulas of time move them, or joints between them. Not collective.
  virtual bool is_driven() const { return false; }
  /// Whether the constraint does no work: nothing that is given moves the nodes. Not collective.
  virtual bool is_ideal() const = 0;
  /// Removes what is prescribed from the velocities of the nodes.
  virtual void subtract_given(Vec v) const = 0;
};

}  // namespace pliant
