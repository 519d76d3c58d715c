/// Checks every return code of PETSc and MPI; a failure throws with the place of the call.
#pragma once

#include <source_location>
#include <stdexcept>
#include <string>

#include <petscsys.h>

namespace pliant {

/// A failure inside PETSc or MPI: a bug or an exhausted resource, never an error in the input.
class PetscFailure : public std::runtime_error {
 public:
  PetscFailure(PetscErrorCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  PetscErrorCode code() const { return code_; }

 private:
  PetscErrorCode code_;
};

/// Throws PetscFailure, naming the caller, unless `code` is success.
void check(PetscErrorCode code, std::source_location where = std::source_location::current());

/// The same for MPI's return codes.
void check_mpi(int code, std::source_location where = std::source_location::current());

}  // namespace pliant
