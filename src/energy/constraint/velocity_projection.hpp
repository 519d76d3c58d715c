/// Velocities that fulfil constraints, nearest in kinetic energy.
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "energy/volume/inertia.hpp"
#include "fem/block_matrix.hpp"
#include "time/stage.hpp"

#include <vector>

namespace pliant {

/// What velocities are projected with. `prescribed`: one flag per owned entry (at least). `map`: nullptr if
/// displacements are prescribed only.
struct ConstrainedMass {
  const NodeLayout& layout;
  const BlockPattern& pattern;
  const Inertia& inertia;
  const std::vector<char>& prescribed;
  ConstraintMap* map;
};

/// Projects velocities onto those that constraints leave:
///
///   v = v_c + J w,  J^T M (v - v') = 0,
///
/// v_c any velocity that fulfils the constraints, v' the one to be projected, J the Jacobian of the constraints' map at
/// the configuration: of all velocities that fulfil the constraints v is the one for which (v - v')^T M (v - v') is
/// least. The change is M^-1 times impulses of the constraints. Those of a rigid part that nothing holds have neither
/// resultant nor moment: it keeps its momenta, and loses no more kinetic energy than it must.
class VelocityProjection {
 public:
  /// What `bodies` refers to outlives the object. Collective.
  explicit VelocityProjection(const ConstrainedMass& bodies);

  /// What is projected.
  enum class Scope {
    all,          ///< v'
    rigid_parts,  ///< v' in rigid parts that turn freely, where nothing is given: the rest fulfils the constraints
  };
  /// v, which fulfils the constraints at q, becomes the projection of v'. Collective.
  void operator()(Vec q, Vec wanted, Vec v, Scope scope);

 private:
  Mat reduced_mass();

  ConstraintMap* map_;
  std::vector<PetscInt> excluded_;  // entries that are not unknowns
  Handle<Mat> mass_, reduced_;
  Handle<KSP> ksp_;
  Handle<Vec> difference_, force_, w_;
};

/// `motion` with its velocities projected: those of a restart, and where rigid parts turn freely, those of the method
/// at the end of a step. What `bodies` refers to outlives all copies, which share their memory.
PrescribedMotion with_projected_velocities(PrescribedMotion motion, const ConstrainedMass& bodies);

}  // namespace pliant
