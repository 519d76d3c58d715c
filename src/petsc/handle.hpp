/// Ownership of PETSc objects: one handle template; raw objects are owned nowhere else.
#pragma once

#include "petsc/check.hpp"

#include <utility>

#include <petscdm.h>
#include <petscdmplextransform.h>
#include <petscis.h>
#include <petscksp.h>
#include <petscmat.h>
#include <petscsection.h>
#include <petscsf.h>
#include <petscsnes.h>
#include <petscts.h>
#include <petscvec.h>

namespace pliant {

/// How to destroy a PETSc object of type T; one overload per type.
inline PetscErrorCode destroy(Vec* x) {
  return VecDestroy(x);
}
inline PetscErrorCode destroy(Mat* x) {
  return MatDestroy(x);
}
inline PetscErrorCode destroy(DM* x) {
  return DMDestroy(x);
}
inline PetscErrorCode destroy(IS* x) {
  return ISDestroy(x);
}
inline PetscErrorCode destroy(KSP* x) {
  return KSPDestroy(x);
}
inline PetscErrorCode destroy(PC* x) {
  return PCDestroy(x);
}
inline PetscErrorCode destroy(SNES* x) {
  return SNESDestroy(x);
}
inline PetscErrorCode destroy(TS* x) {
  return TSDestroy(x);
}
inline PetscErrorCode destroy(PetscSection* x) {
  return PetscSectionDestroy(x);
}
inline PetscErrorCode destroy(PetscSF* x) {
  return PetscSFDestroy(x);
}
inline PetscErrorCode destroy(DMPlexTransform* x) {
  return DMPlexTransformDestroy(x);
}
inline PetscErrorCode destroy(PetscLayout* x) {
  return PetscLayoutDestroy(x);
}
inline PetscErrorCode destroy(MatNullSpace* x) {
  return MatNullSpaceDestroy(x);
}

/// The single owner of a PETSc object. Movable, not copyable; `share()` makes a second owner on purpose.
template <class T>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    PetscBool finalized = PETSC_FALSE;
    if (object_ != nullptr && PetscFinalized(&finalized) == 0 && !finalized) (void)destroy(&object_);
  }

  T get() const { return object_; }
  explicit operator bool() const { return object_ != nullptr; }

  /// For PETSc's creating calls: `check(VecCreate(comm, v.out()))`. Destroys the object held before.
  T* out() {
    if (object_ != nullptr) check(destroy(&object_));
    return &object_;
  }

  /// Gives the object up to the caller.
  T release() { return std::exchange(object_, nullptr); }

  /// A second owner of the same object.
  Handle share() const {
    if (object_ != nullptr) check(PetscObjectReference(reinterpret_cast<PetscObject>(object_)));
    return Handle(object_);
  }

 private:
  T object_ = nullptr;
};

}  // namespace pliant
