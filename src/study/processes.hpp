/// Runs other programs, several at a time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pliant {

/// Variables as "NAME=value".
using Environment = std::vector<std::string>;

/// The environment of this process, to be taken before MPI starts: MPI adds variables that make programs believe that
/// they belong to the same job.
Environment current_environment();

struct Program {
  std::vector<std::string> arguments;  ///< the first one: the program, as a path or to be searched for in PATH
  std::filesystem::path log;           ///< its output is appended here; empty: it has our input and outputs
};

/// How a program ended.
struct Ended {
  int code = 0;          ///< its exit code; 128 + the number of the signal that ended it; 127: it could not be started
  double seconds = 0.0;  ///< wall-clock time
};

/// Runs all programs, at most `at_once` at a time, in their order; calls `on_end` (index, how) as they end. A signal
/// that asks to stop (`stop_signals`) is handed on to those that run, and no further one is started: those count as
/// ended by the signal. Not collective.
std::vector<Ended> run_all(const std::vector<Program>& programs, const Environment& environment, int at_once,
                           const std::function<void(std::size_t, const Ended&)>& on_end);

/// Processors that this process may use.
int usable_processors();

}  // namespace pliant
