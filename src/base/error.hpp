/// Failures: the type says who has to act, and decides the exit code.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Exit code of the program; the same on every rank. `unexpected` is a failure that no other code covers, such as
/// running out of memory (EX_SOFTWARE of sysexits.h).
enum class ExitCode : int {
  done = 0,
  study_failed = 1,
  input = 2,
  solve = 3,
  file = 4,
  unexpected = 70,
  interrupted = 130
};

/// A place in a file the user wrote. Lines and columns count from 1; 0 means "not known".
struct Location {
  std::string file;
  int line = 0;
  int column = 0;
};

/// "file:line:column", with the unknown parts left out.
std::string to_string(const Location& where);

/// An error keeps a run from starting. A warning is about what is legal and seldom meant; a note informs.
enum class Severity { error, warning, note };

/// What the user should know of the input: where it stands, what is wrong with it and what to do about it.
struct Diagnostic {
  Severity severity = Severity::error;
  Location where;  ///< without a file: no single place
  std::string message;
};

/// About no single place of the input.
Diagnostic note(std::string message);
/// "file:line:column: message", without the severity.
std::string to_string(const Diagnostic& diagnostic);

/// The user's input is wrong (exit code 2). Carries every error found, so that all are reported at once.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Diagnostic> diagnostics);
  InputError(Location where, std::string message)
      : InputError(std::vector<Diagnostic>{{Severity::error, std::move(where), std::move(message)}}) {}
  /// All of severity error.
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// A file could not be read or written (exit code 4).
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The solve failed after every retry (exit code 3).
class SolveError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace pliant
