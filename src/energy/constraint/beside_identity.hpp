/// A matrix that acts on the displacements among the unknowns, and as the identity on the other unknowns.
#pragma once

#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// [A, 0; 0, I], where A is a square matrix of the first unknowns of each rank; A itself if there are no others.
class BesideIdentity {
 public:
  /// A of type MATMPIAIJ; `unknowns`: a vector of them. Collective.
  BesideIdentity(Mat A, Vec unknowns);

  /// To be called after entries of A have changed, in the same pattern. Collective.
  void update();
  Mat matrix() const { return whole_.get(); }
  /// The row of A with this global number, as a row among the unknowns. Not collective.
  PetscInt place(PetscInt row) const;

 private:
  Mat A_;
  Handle<Mat> whole_;
  std::vector<PetscInt> first_row_, first_unknown_;  // of each rank
};

}  // namespace pliant
