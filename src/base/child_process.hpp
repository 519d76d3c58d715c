/// Runs work that may crash or exit in a child process.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace pliant {

/// How a child process ended.
struct ChildEnd {
  /// The result of the work; empty if the child died or exited.
  std::optional<std::string> answer;
  bool exited = false;       ///< it called exit
  bool is_too_late = false;  ///< it was killed because its time was over
  std::string how;           ///< "Segmentation fault", "exit code 3"
};

/// reading: the child can run no program, write no file and open no socket (base/confinement.hpp).
enum class ChildRights { all, reading };

struct ChildLimits {
  ChildRights rights = ChildRights::all;
  std::optional<std::chrono::milliseconds> time = {};  ///< the child is killed after this time
};

/// Runs `work` in a child process of this one. Changes to files persist; all memory that the child took is returned.
/// The child has no standard output, must not use MPI, and never outlives this process. `work` must not throw. Throws
/// std::system_error if no process can be started. Not collective.
ChildEnd in_child(const std::function<std::string()>& work, const ChildLimits& limits = {});

}  // namespace pliant
