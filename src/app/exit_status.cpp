#include "app/exit_status.hpp"

#include "petsc/session.hpp"

#include <cstdio>
#include <exception>

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
    fmt::print(stderr, "pliant failed on rank {}: {}\n", rank(PETSC_COMM_WORLD), error.what());
    std::fflush(stderr);
    MPI_Abort(PETSC_COMM_WORLD, static_cast<int>(ExitCode::solve));
    return static_cast<int>(ExitCode::solve);
  }
}

}  // namespace pliant
