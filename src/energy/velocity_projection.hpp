/// Velocities that fulfil constraints, nearest in kinetic energy.
#pragma once

#include "energy/constraint_map.hpp"
#include "energy/inertia.hpp"
#include "fem/block_matrix.hpp"
#include "time/stage.hpp"

#include <vector>

namespace pliant {

/// Projects velocities onto those that constraints leave, where rigid parts turn freely:
///
///   v = v_c + J w,  J^T M (v - v') = 0,
///
/// v_c any velocity that fulfils the constraints, v' the one to be projected, J the Jacobian of the constraints' map at
/// the configuration. The change is M^-1 times forces of the constraint, which have neither resultant nor moment: a
/// body that nothing holds keeps its momenta, and loses no more kinetic energy than it must.
class VelocityProjection {
 public:
  /// `prescribed`: one flag per owned entry (at least). The references outlive the object. Collective.
  VelocityProjection(const NodeLayout& layout, const BlockPattern& pattern, const Inertia& inertia,
                     const std::vector<char>& prescribed, ConstraintMap& map);

  /// v, which fulfils the constraints at q, becomes the projection of v'. Collective.
  void operator()(Vec q, Vec wanted, Vec v);

 private:
  ConstraintMap& map_;
  std::vector<PetscInt> excluded_;  // entries that are no unknowns
  Handle<Mat> mass_, reduced_;
  Handle<KSP> ksp_;
  Handle<Vec> difference_, force_, w_;
};

/// `motion` with its velocities at the end of a step projected from those of the method. The projection is shared by
/// all copies.
PrescribedMotion with_projected_velocities(PrescribedMotion motion, VelocityProjection projection,
                                           const NodeLayout& layout);

}  // namespace pliant
