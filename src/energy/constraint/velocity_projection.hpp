/// Projection of velocities onto the constraints, in the norm of the kinetic energy.
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "energy/volume/inertia.hpp"
#include "petsc/callback.hpp"
#include "time/stage.hpp"

#include <vector>

namespace pliant {

/// The data of a projection. `prescribed`: one flag per owned entry (at least). `map`: nullptr if only displacements
/// are prescribed.
struct ConstrainedMass {
  const NodeLayout& layout;
  const Inertia& inertia;
  const std::vector<char>& prescribed;
  ConstraintMap* map;
};

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
  VelocityProjection(const VelocityProjection&) = delete;  // PETSc's objects point to it
  VelocityProjection& operator=(const VelocityProjection&) = delete;

  /// Which velocities are projected.
  enum class Scope {
    all,         ///< v'
    dependents,  ///< v' at dependent nodes (rigid parts), where nothing is prescribed: all others fulfil the
                 ///< constraints already
  };
  /// Replaces v, which fulfils the constraints at q, by the projection of v'. Collective.
  void operator()(Vec q, Vec wanted, Vec v, Scope scope);

 private:
  static PetscErrorCode multiply_callback(Mat A, Vec x, Vec y);
  static PetscErrorCode diagonal_callback(Mat A, Vec diagonal);
  /// y = J^T M J x.
  void multiply(Vec x, Vec y);
  /// f = J^T M v, whose ghosts it updates.
  void put_force(Vec v, Vec f);
  void clear_excluded(Vec x) const;

  ConstraintMap* map_;
  const MassMatrix& mass_;
  std::vector<char> is_excluded_;  // entries that are not unknowns
  Handle<Mat> reduced_;            // J^T M J, on unknowns
  Handle<KSP> ksp_;
  Handle<Vec> expanded_, force_, w_, rhs_, diagonal_, masses_;
  CallbackGuard guard_;
};

/// `motion` with its velocities projected: after a restart and, where rigid parts rotate freely, those of the method at
/// the end of a step. The references in `bodies` must outlive all copies, which share their memory.
PrescribedMotion with_projected_velocities(PrescribedMotion motion, const ConstrainedMass& bodies);

}  // namespace pliant
