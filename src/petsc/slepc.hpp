/// Ownership of SLEPc's eigensolvers, and its lifetime: apart from petsc/handle.hpp, because few need them.
#pragma once

#include "petsc/handle.hpp"

#include <slepceps.h>

/// How to destroy one. In the namespace of SLEPc's type, where Handle finds it.
inline PetscErrorCode destroy(EPS* x) {
  return EPSDestroy(x);
}

namespace pliant {

/// The lifetime of SLEPc within that of PETSc: what is made of it ends before the object. Collective.
class SlepcSession {
 public:
  SlepcSession() { check(SlepcInitialize(nullptr, nullptr, nullptr, nullptr)); }
  ~SlepcSession() { (void)SlepcFinalize(); }
  SlepcSession(const SlepcSession&) = delete;
  SlepcSession& operator=(const SlepcSession&) = delete;
};

}  // namespace pliant
