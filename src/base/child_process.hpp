/// Work that may crash or exit, done where it hurts nobody.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace pliant {

/// How a child process ended.
struct ChildEnd {
  /// What its work gave; nothing if it died or ended itself.
  std::optional<std::string> answer;
  bool exited = false;  ///< it ended itself
  std::string how;      ///< "Segmentation fault", "exit code 3"
};

/// Runs `work` in a child process of this one. What the child does to files stays; all memory that it took is returned.
/// It has no standard output, must not use MPI, and never outlives this process. `work` must not throw. Throws
/// std::system_error if there can be no more processes. Not collective.
ChildEnd in_child(const std::function<std::string()>& work);

}  // namespace pliant
