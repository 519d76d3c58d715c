/// The keyword lines ("cards") and data lines of Abaqus and CalculiX.
#pragma once

#include "mesh/formats/line_reader.hpp"

#include <map>
#include <string>
#include <vector>

namespace pliant {

/// "*NSET, NSET=clamp, GENERATE": names of keyword and parameters in capitals without blanks, values as in the file.
struct AbaqusCard {
  std::string keyword;
  std::map<std::string, std::string> parameters;
  std::size_t line = 0;

  bool has(const std::string& parameter) const { return parameters.contains(parameter); }
  std::string value(const std::string& parameter) const;  ///< empty if there is none
};

/// Reads cards and the data lines between them; skips comments and empty lines.
class AbaqusCards {
 public:
  explicit AbaqusCards(const std::string& file) : in_(file) {}

  /// Skips data lines to the next card, which it takes; false at the end. Files of *INCLUDE are read in its place.
  bool next(AbaqusCard& card);
  /// The entries of the next data line, without blanks around them; false at a card, and at the end. A comma at the end
  /// of a line gives no entry; `continues` says whether there was one.
  bool next_data(std::vector<std::string>& entries);
  bool continues() const { return continues_; }

  LineReader& lines() { return in_; }
  [[noreturn]] void fail(const std::string& message) const { in_.fail(message); }
  /// The entry as a positive number of a node or element, or as a coordinate; `what` names it in messages.
  std::size_t label(const std::string& entry, const char* what) const;
  double real(const std::string& entry, const char* what) const;

 private:
  bool next_line();

  LineReader in_;
  bool is_waiting_ = false;  // the current line has not been taken
  bool continues_ = false;
};

}  // namespace pliant
