/// The near-null space of a matrix: the modes of little energy that multigrid represents on coarse levels.
#pragma once

#include "petsc/handle.hpp"

#include <vector>

namespace pliant {

/// The space of the modes, made orthonormal, without those that others span. Collective.
Handle<MatNullSpace> near_null_space(MPI_Comm comm, std::vector<Handle<Vec>> modes);
/// Gives it to the matrix as its near-null space. Collective.
void set_near_null_modes(Mat matrix, std::vector<Handle<Vec>> modes);

}  // namespace pliant
