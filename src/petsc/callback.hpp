/// C++ exceptions must not pass through PETSc's C frames: a callback stores them and returns an error code instead.
#pragma once

#include "petsc/check.hpp"

#include <exception>
#include <utility>

namespace pliant {

/// Holds the exception of a callback until control is back in C++.
class CallbackGuard {
 public:
  /// Runs the callback's body; 0, or a PETSc code if it threw.
  template <class Body>
  PetscErrorCode run(Body body) noexcept {
    try {
      body();
      return 0;
    } catch (const PetscFailure& failure) {
      caught_ = std::current_exception();
      return failure.code();
    } catch (...) {
      caught_ = std::current_exception();
      return PETSC_ERR_LIB;
    }
  }

  /// To be called after the PETSc call that returned `code`: rethrows the callback's exception, or throws PetscFailure
  /// for `code`.
  void rethrow(PetscErrorCode code, std::source_location where = std::source_location::current()) {
    if (caught_) std::rethrow_exception(std::exchange(caught_, nullptr));
    check(code, where);
  }

 private:
  std::exception_ptr caught_;
};

}  // namespace pliant
