// pliant: the program. Starts MPI and PETSc, runs the command, turns failures into messages and exit codes.
#include "command/command_line.hpp"
#include "command/exit_status.hpp"
#include "petsc/blas_kernels.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <csignal>
#include <optional>
#include <string>
#include <vector>

using namespace pliant;

int main(int argc, char** argv) {
  take_fitting_blas_kernels(argv);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a failed write, which is reported, not a sudden end
  char** const separator = std::find_if(argv, argv + argc, [](const char* a) { return std::string(a) == "--"; });
  const std::vector<std::string> petsc_options(std::min(separator + 1, argv + argc), argv + argc);
  SweepOptions sweep;
  sweep.petsc_options = petsc_options;
  sweep.environment = current_environment();
  std::optional<Session> session;  // lives until the exit status is reported
  return exit_status([&] {
    session.emplace(argv[0], petsc_options);
    return CommandLine(PETSC_COMM_WORLD, sweep)(static_cast<int>(separator - argv), argv);
  });
}
