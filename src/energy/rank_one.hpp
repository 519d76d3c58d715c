/// A part of a Hessian that is stored by its factors.
#pragma once

#include "petsc/handle.hpp"

namespace pliant {

/// c g g^T: it couples all entries of g with all, and would fill the matrix.
struct RankOne {
  double c = 0.0;  ///< >= 0
  Handle<Vec> g;   ///< zero on prescribed entries
};

}  // namespace pliant
