/// Ownership of PETSc's optimisers (TAO): apart from petsc/handle.hpp, because few need them.
#pragma once

#include "petsc/handle.hpp"

#include <petsctao.h>

/// How to destroy one. In the namespace of PETSc's type, where Handle finds it.
inline PetscErrorCode destroy(Tao* x) {
  return TaoDestroy(x);
}
