/// A matrix that acts on the displacements among the unknowns, and leaves the others as they are.
#pragma once

#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// [A, 0; 0, I], A a square matrix of the first unknowns of each rank; A itself where there are no others.
class BesideIdentity {
 public:
  /// A of type MATMPIAIJ; `unknowns`: a vector of them. Collective.
  BesideIdentity(Mat A, Vec unknowns);

  /// After entries of A have changed, in the places that it had. Collective.
  void update();
  Mat matrix() const { return whole_.get(); }
  /// The row of A that has this number, over all ranks, among the unknowns. Not collective.
  PetscInt place(PetscInt row) const;

 private:
  Mat A_;
  Handle<Mat> whole_;
  std::vector<PetscInt> first_row_, first_unknown_;  // of each rank
};

}  // namespace pliant
