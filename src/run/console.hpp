/// Output for the user during a run: rank 0's terminal.
#pragma once

#include "base/error.hpp"

#include <string>
#include <vector>

#include <mpi.h>

namespace pliant {

enum class Verbosity { normal, quiet };

/// Prints on rank 0; warnings always, the rest unless quiet. Not collective. On a terminal the progress line is
/// rewritten in place.
class Console {
 public:
  Console(MPI_Comm comm, Verbosity verbosity);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void print(const std::string& line);
  void note(const std::string& line);
  void warn(const std::string& line);
  /// Prints a note to standard output, a warning or an error to standard error.
  void report(const Diagnostic& diagnostic);
  /// Prints a line that the next one replaces; only on a terminal.
  void progress(const std::string& line);
  bool is_terminal() const { return is_terminal_; }
  /// All notes and warnings so far, each in their order, those that were not printed too; on rank 0.
  const std::vector<std::string>& notes() const { return notes_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void clear_progress();

  bool speaks_;
  bool quiet_;
  bool is_terminal_;
  bool progress_shown_ = false;
  std::vector<std::string> notes_, warnings_;
};

}  // namespace pliant
