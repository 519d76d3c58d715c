/// The first entries of each rank's part of a vector as a vector of their own, without a copy.
#pragma once

#include "petsc/handle.hpp"

namespace pliant {

/// A vector without memory of its own that views the memory of another.
class LeadingPart {
 public:
  /// With as many entries per rank as `like`. Collective.
  explicit LeadingPart(Vec like) {
    PetscInt size = 0, total = 0;
    check(VecGetLocalSize(like, &size));
    check(VecGetSize(like, &total));
    check(VecCreateMPIWithArray(PetscObjectComm(reinterpret_cast<PetscObject>(like)), 1, size, total, nullptr,
                                part_.out()));
  }

  /// The first entries of `whole`, for reading and writing, while the object lives; one at a time.
  class Of {
   public:
    Of(const LeadingPart& part, Vec whole) : part_(part.part_.get()), whole_(whole) {
      check(VecGetArray(whole_, &data_));
      check(VecPlaceArray(part_, data_));
    }
    ~Of() {
      (void)VecResetArray(part_);
      (void)VecRestoreArray(whole_, &data_);
    }
    Of(const Of&) = delete;
    Of& operator=(const Of&) = delete;
    Vec get() const { return part_; }

   private:
    Vec part_, whole_;
    double* data_ = nullptr;
  };

 private:
  Handle<Vec> part_;
};

}  // namespace pliant
