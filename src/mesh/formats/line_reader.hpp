/// Reads text files line by line, with the place of each line for messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// The lines of a file and of those that it includes, as one sequence numbered from 1.
class LineReader {
 public:
  /// Throws FileError if the file cannot be read.
  explicit LineReader(const std::string& file);

  /// Moves to the next line; false behind the last one.
  bool next();
  /// The current line without blanks at its end; valid until `next`.
  std::string_view text() const { return text_; }
  std::size_t number() const { return number_; }
  /// Continues with the lines of another file, named relative to the current one. Throws MeshDefect if it cannot be
  /// read, or if files include one another endlessly.
  void include(const std::string& file);

  /// "line 12", or "line 12 of 'part.inp'" in an included file.
  std::string place(std::size_t number) const;
  /// Throws MeshDefect "<place>: <message>".
  [[noreturn]] void fail(std::size_t number, const std::string& message) const;
  [[noreturn]] void fail(const std::string& message) const { fail(number_, message); }

 private:
  struct Source {
    std::string name;  // empty for the file itself
    std::string bytes;
    std::size_t at = 0;
    std::size_t line = 0;  // of this file
  };
  struct Piece {
    std::size_t first;  // number in the sequence
    std::string name;
    std::size_t line;
  };
  std::string file_;
  std::deque<Source> sources_;  // the innermost last
  std::vector<Piece> pieces_;
  std::string_view text_;
  std::size_t number_ = 0;
};

/// The text as an integer or a real number, blanks around it ignored; nothing if it is something else. Real numbers may
/// have Fortran's exponents (1.5D+03).
std::optional<std::int64_t> integer_in(std::string_view text);
std::optional<double> real_in(std::string_view text);

/// "'text'", shortened and printable.
std::string in_quotes(std::string_view text);

/// The text in capitals (ASCII).
std::string in_capitals(std::string_view text);

}  // namespace pliant
