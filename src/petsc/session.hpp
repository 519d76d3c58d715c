/// The lifetime of MPI and PETSc in the process.
#pragma once

#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Initialises MPI and PETSc, each unless somebody else has (mpi4py, petsc4py), and finalises at the end of the scope
/// what it initialised. One per process. Collective.
/// PETSc's own error traces are silenced: failures travel as exceptions (check.hpp) and are reported once.
class Session {
 public:
  /// `petsc_options`: arguments in PETSc's syntax, e.g. {"-snes_monitor"}; the environment variable PETSC_OPTIONS
  /// counts too. Throws InputError for options that cannot be parsed, before other ranks know of them.
  Session(const std::string& program, const std::vector<std::string>& petsc_options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  bool owns_petsc_ = true;
};

/// Silences PETSc's error traces in a scope, whoever has set another handler since the session began. Not collective.
class SilentPetsc {
 public:
  SilentPetsc();
  ~SilentPetsc();
  SilentPetsc(const SilentPetsc&) = delete;
  SilentPetsc& operator=(const SilentPetsc&) = delete;
};

/// Rank and number of ranks of a communicator. Not collective.
int rank(MPI_Comm comm);
int num_ranks(MPI_Comm comm);

/// All active PETSc options, as on a command line.
std::string petsc_options();

/// Options of the command line that no object has queried, e.g. misspelt ones.
std::vector<std::string> unused_petsc_options();

}  // namespace pliant
