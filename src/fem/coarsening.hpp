/// The linear functions within the quadratic ones: the coarse space of p-multigrid.
#pragma once

#include "fem/layout.hpp"
#include "petsc/handle.hpp"

#include <span>

namespace pliant {

/// The space of P1 displacements inside that of P2 displacements on the same mesh.
struct Coarsening {
  Handle<Mat> prolongation;  ///< P2 values of P1 functions; columns: three per vertex, by owner
};

/// Restriction of quadratic elements: vertices keep their values, mid-edge nodes take the mean of two. Functions of the
/// coarse space are zero on prescribed entries (flags as in RowElimination), except for those at vertices, which are
/// decoupled in both spaces. Collective.
Coarsening make_coarsening(const NodeLayout& layout, std::span<const char> is_prescribed);

}  // namespace pliant
