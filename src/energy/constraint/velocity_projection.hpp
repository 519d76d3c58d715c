/// Projection of velocities onto the constraints, in the norm of the kinetic energy.
#pragma once

#include "energy/constraint/reduced_mass.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Projects velocities onto those that the constraints allow:
///
///   v = v_c + J w,  J^T M (v - v') = 0,
///
/// v_c is any velocity that fulfils the constraints, v' the one to be projected, J the Jacobian of the constraints' map
/// at the configuration: among all velocities that fulfil the constraints, v minimises (v - v')^T M (v - v'). The
/// change is M^-1 times impulses of the constraints. For a free rigid part these have neither resultant nor moment: it
/// keeps its momenta, and loses no more kinetic energy than it must.
class VelocityProjection {
 public:
  /// The references in `bodies` must outlive the object. Collective.
  explicit VelocityProjection(const ConstrainedMass& bodies);

  /// Which velocities are projected.
  enum class Scope {
    all,         ///< v'
    dependents,  ///< v' at dependent nodes (rigid parts), where nothing is prescribed: all others fulfil the
                 ///< constraints already
  };
  /// Replaces v, which fulfils the constraints at q, by the projection of v'. Collective.
  void operator()(Vec q, Vec wanted, Vec v, Scope scope);

 private:
  ConstraintMap* map_;
  ReducedMass mass_;
  Handle<Vec> difference_, rhs_, w_;
};

/// The velocities of rigid parts that rotate freely, at the end of a step of a method.
enum class EndVelocities {
  projected,
  /// Those of the method, which the constraints allow except for an error of second order, unless formulas of time move
  /// joints or parts (DependentNodes::is_driven). A midpoint rule whose configurations fulfil quadratic constraints at
  /// both ends keeps the energy of the motion; a projection takes some of it away in each step. Source: Gonzalez 1999,
  /// Mechanical systems subject to holonomic constraints: differential-algebraic formulations and conservative
  /// integration.
  of_method
};

/// `motion` with its velocities projected: after a restart and, where rigid parts rotate freely, those at the end of a
/// step. The references in `bodies` must outlive all copies, which share their memory.
PrescribedMotion with_projected_velocities(PrescribedMotion motion, const ConstrainedMass& bodies,
                                           EndVelocities end_velocities);

}  // namespace pliant
