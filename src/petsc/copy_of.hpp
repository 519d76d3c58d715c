/// Copies of vectors.
#pragma once

#include "petsc/check.hpp"
#include "petsc/handle.hpp"

namespace pliant {

/// A vector with the same entries; null of nullptr. Collective.
inline Handle<Vec> copy_of(Vec x) {
  Handle<Vec> copy;
  if (x == nullptr) return copy;
  check(VecDuplicate(x, copy.out()));
  check(VecCopy(x, copy.get()));
  return copy;
}

}  // namespace pliant
