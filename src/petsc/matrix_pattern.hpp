/// Matrices whose nonzero pattern changes while others refer to them.
#pragma once

#include "petsc/handle.hpp"

#include <algorithm>
#include <vector>

namespace pliant {

/// Names the pattern of a matrix: it stays while values change, and is another one in every other matrix. Not
/// collective.
inline PetscObjectId pattern_id(Mat matrix) {
  PetscObjectId id = 0;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(matrix), &id));
  return id;
}

/// Whether an object that is set up for matrices (a preconditioner) was last set up for one with another pattern, which
/// PETSc may not notice; it takes that of `matrix` from now on. Not collective.
bool takes_new_pattern(PetscObject object, Mat matrix);

/// Makes the pattern of the next matrix a new one for the object.
void forget_pattern(PetscObject object);

/// Which matrices have the present pattern of an equation. All that were made before the pattern changed for the first
/// time have it until then; solvers keep the matrix that they were given, whatever its pattern becomes.
class PresentPattern {
 public:
  bool is_that_of(Mat matrix) const { return is_first_ || std::ranges::find(ids_, pattern_id(matrix)) != ids_.end(); }
  /// From now on the present pattern is one that no matrix has.
  void change() {
    is_first_ = false;
    ids_.clear();
  }
  /// Lets `matrix` become `by`, which has the present pattern, with its values and near-null space, for all who refer
  /// to it. Collective.
  void give(Mat matrix, Handle<Mat> by) {
    Mat taken = by.release();
    check(MatHeaderReplace(matrix, &taken));
    ids_.push_back(pattern_id(matrix));
  }

 private:
  bool is_first_ = true;
  std::vector<PetscObjectId> ids_;
};

}  // namespace pliant
