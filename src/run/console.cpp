#include "run/console.hpp"

#include "petsc/session.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Whether standard output is a terminal that the user sees. Open MPI's mpirun gives every rank a pseudo-terminal of
/// its own; under mpirun the output of mpirun itself, the parent, decides.
bool output_is_terminal() {
  if (isatty(STDOUT_FILENO) == 0) return false;
  if (std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr) return true;
  std::error_code error;
  const auto target = std::filesystem::read_symlink(fmt::format("/proc/{}/fd/1", getppid()), error);
  return !error && target.string().starts_with("/dev/") && target != "/dev/null";
}

}  // namespace

Console::Console(MPI_Comm comm, Verbosity verbosity)
    : speaks_(rank(comm) == 0), quiet_(verbosity == Verbosity::quiet), is_terminal_(output_is_terminal()) {}

Console::~Console() {
  clear_progress();
}

void Console::clear_progress() {
  if (!progress_shown_) return;
  fmt::print("\r\033[K");
  std::fflush(stdout);
  progress_shown_ = false;
}

void Console::print(const std::string& line) {
  if (!speaks_ || quiet_) return;
  clear_progress();
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

void Console::note(const std::string& line) {
  if (!speaks_) return;
  notes_.push_back(line);
  print("note: " + line);
}

void Console::warn(const std::string& line) {
  if (!speaks_) return;
  warnings_.push_back(line);
  clear_progress();
  fmt::print(stderr, "warning: {}\n", line);
}

void Console::report(const Diagnostic& diagnostic) {
  switch (diagnostic.severity) {
    case Severity::note:
      return note(to_string(diagnostic));
    case Severity::warning:
      return warn(to_string(diagnostic));
    case Severity::error:
      break;
  }
  if (!speaks_) return;
  clear_progress();
  fmt::print(stderr, "{}\n", to_string(diagnostic));
}

void Console::progress(const std::string& line) {
  if (!speaks_ || quiet_ || !is_terminal_) return;
  fmt::print("\r\033[K{}", line);
  std::fflush(stdout);
  progress_shown_ = true;
}

}  // namespace pliant
