/// The mass matrix in the unknowns that constraints leave.
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "energy/volume/inertia.hpp"
#include "petsc/callback.hpp"

#include <vector>

namespace pliant {

/// Bodies and their constraints. `prescribed`: one flag per owned entry (at least). `map`: nullptr if only
/// displacements are prescribed.
struct ConstrainedMass {
  const NodeLayout& layout;
  const Inertia& inertia;
  const std::vector<char>& prescribed;
  ConstraintMap* map;
};

/// J^T M J on some of the unknowns, with the Jacobian J of the constraints' map, and its inverse by conjugate
/// gradients. All methods are collective.
class ReducedMass {
 public:
  /// `is_excluded`: per owned entry, whether it is not one of these unknowns. The references in `bodies` outlive the
  /// object.
  ReducedMass(const ConstrainedMass& bodies, std::vector<char> is_excluded);
  ReducedMass(const ReducedMass&) = delete;  // PETSc's objects point to it
  ReducedMass& operator=(const ReducedMass&) = delete;

  /// f = M v [kg times the unit of v].
  void multiply(Vec v, Vec f);
  /// g = J^T f, zero in entries that are excluded.
  void reduce(Vec f, Vec g) const;
  /// v = J w.
  void expand(Vec w, Vec v) const;
  /// Solves J^T M J w = b with the present J, up to a residual of `relative` |b| or `absolute`, divided by the
  /// diagonal. Entries of w and b that are excluded are zero.
  void solve(Vec b, Vec w, double relative, double absolute);

 private:
  static PetscErrorCode multiply_callback(Mat A, Vec x, Vec y);
  static PetscErrorCode diagonal_callback(Mat A, Vec diagonal);
  void apply(Vec x, Vec y);

  ConstraintMap* map_;
  const MassMatrix& mass_;
  std::vector<char> is_excluded_;
  Handle<Mat> operator_;
  Handle<KSP> ksp_;
  Handle<Vec> expanded_, force_, ghosted_, diagonal_, masses_;
  CallbackGuard guard_;
};

}  // namespace pliant
