/// The parts of a saddle point's matrix, attached to it for those who precondition it, as PETSc attaches near-null
/// spaces.
#pragma once

#include "petsc/handle.hpp"

#include <optional>

#include <petscmat.h>

namespace pliant {

struct SaddlePointParts {
  IS displacements;  ///< global rows of this rank, in blocks of three, with their near-null space ("nearnullspace")
  IS pressures;      ///< likewise
  Mat schur;         ///< close to the Schur complement of the pressures; negative definite
};

/// Collective.
void attach(Mat A, const SaddlePointParts& parts);

/// What is attached to a matrix; it lives as long as the matrix.
std::optional<SaddlePointParts> saddle_point_of(Mat A);

}  // namespace pliant
