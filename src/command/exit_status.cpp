#include "command/exit_status.hpp"

#include "petsc/session.hpp"

#include <cstdio>
#include <exception>
#include <new>

#include <fmt/format.h>

namespace pliant {
namespace {

int told(const std::exception& error, ExitCode code) {
  if (rank(PETSC_COMM_WORLD) == 0) fmt::print(stderr, "{}\n", error.what());
  return static_cast<int>(code);
}

}  // namespace

int exit_status(const std::function<ExitCode()>& program) {
  try {
    return static_cast<int>(program());
  } catch (const InputError& error) {
    return told(error, ExitCode::input);
  } catch (const FileError& error) {
    return told(error, ExitCode::file);
  } catch (const SolveError& error) {
    return told(error, ExitCode::solve);
  } catch (const std::exception& error) {
    // Not agreed between ranks: the others may be waiting for this one.
    const bool lacks_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    fmt::print(stderr, "pliant failed on rank {}: {}\n", rank(PETSC_COMM_WORLD),
               lacks_memory ? "this machine has too little memory; use more machines, fewer ranks on each, or a "
                              "coarser mesh"
                            : error.what());
    std::fflush(stderr);
    MPI_Abort(PETSC_COMM_WORLD, static_cast<int>(ExitCode::unexpected));
    return static_cast<int>(ExitCode::unexpected);
  }
}

}  // namespace pliant
