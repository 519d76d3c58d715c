/// Work that may crash or exit, done where it hurts nobody.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace pliant {

/// How a child process ended.
struct ChildEnd {
  /// What its work gave; nothing if it died or ended itself.
  std::optional<std::string> answer;
  bool exited = false;       ///< it ended itself
  bool is_too_late = false;  ///< it was ended when its time was over
  std::string how;           ///< "Segmentation fault", "exit code 3"
};

/// reading: the child can run no program, write no file and open no socket (base/confinement.hpp).
enum class ChildRights { all, reading };

struct ChildLimits {
  ChildRights rights = ChildRights::all;
  std::optional<std::chrono::milliseconds> time = {};  ///< the child is ended after it
};

/// Runs `work` in a child process of this one. What the child does to files stays; all memory that it took is returned.
/// It has no standard output, must not use MPI, and never outlives this process. `work` must not throw. Throws
/// std::system_error if there can be no more processes. Not collective.
ChildEnd in_child(const std::function<std::string()>& work, const ChildLimits& limits = {});

}  // namespace pliant
