/// Every return code of PETSc and MPI is checked; a failure throws with the place it came from.
#pragma once

#include <source_location>
#include <stdexcept>
#include <string>

#include <petscsys.h>

namespace pliant {

/// A failure inside PETSc or MPI: a bug or an exhausted resource, never a user's mistake.
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
