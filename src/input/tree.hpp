/// The input file as a tree of texts with their places, its YAML text, and changes from the command line.
#pragma once

#include "base/error.hpp"

#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pliant {

struct KeyInfo;

/// Collects what is wrong with an input, so that all of it is reported at once, and what may be.
class Diagnostics {
 public:
  /// An error.
  void add(Location where, std::string message) {
    found_.push_back({{Severity::error, std::move(where), std::move(message)}, {}});
  }
  void warn(Location where, std::string message) {
    warnings_.push_back({Severity::warning, std::move(where), std::move(message)});
  }
  /// A section lacks one of these keys.
  struct Lack {
    Location section;
    std::vector<std::string> keys;
  };
  /// The error of a lack, unless one of the keys is there but wrong, which is an error already.
  void add(Lack lack, Location where, std::string message) {
    found_.push_back({{Severity::error, std::move(where), std::move(message)}, std::move(lack)});
  }
  /// An error says what is wrong with `key` of the section, or with a misspelling of it.
  void note_wrong(const Location& section, const std::string& key) { wrong_.emplace(to_string(section), key); }
  /// All keys of the file that is read, in which an unknown key of a section is looked up. Kept by the caller.
  void look_up_in(const KeyInfo& file) { keys_of_file_ = &file; }
  const KeyInfo* keys_of_file() const { return keys_of_file_; }
  std::size_t num_errors() const { return found_.size(); }
  /// Throws InputError with every error, in the order of the file; returns if there is none.
  void throw_if_errors() const;
  const std::vector<Diagnostic>& warnings() const { return warnings_; }

 private:
  struct Error {
    Diagnostic diagnostic;
    Lack lack;  // without keys: no lack
  };
  bool is_wrong(const Lack& lack) const;

  std::vector<Error> found_;
  std::vector<Diagnostic> warnings_;
  std::set<std::pair<std::string, std::string>> wrong_;  // where the section is, the key meant
  const KeyInfo* keys_of_file_ = nullptr;
};

/// A value of the input and, in a map, its key. Aliases are resolved (copied).
struct InputNode {
  enum class Kind { null, scalar, list, map };
  Kind kind = Kind::null;
  std::string key;                  ///< empty unless in a map
  std::string text;                 ///< scalar; of a null, which is none, "null" if it is written out
  std::vector<InputNode> children;  ///< list: items; map: values with their keys, each key once
  Location where;                   ///< of the value
  Location key_where;
  /// `word`: true or false, which must not be quoted.
  enum class Style { plain, quoted, word } style = Style::plain;

  static InputNode scalar(std::string text);
  static InputNode list(std::vector<InputNode> items);
  static InputNode map(std::vector<InputNode> entries);
  /// The same value under a key.
  InputNode under(std::string new_key) &&;

  /// The value of a key of a map; none (also for anything but a map): nullptr.
  const InputNode* find(std::string_view name) const;
  /// Where a message about this value should point: a value left empty has no place of its own.
  const Location& place() const { return kind == Kind::null && !key.empty() ? key_where : where; }
};

/// The value at a path of keys; nullptr if it is not there or empty.
const InputNode* given(const InputNode& root, std::initializer_list<std::string_view> path);

/// "a list", "a map of keys", "empty" or "'the text'", for messages.
std::string description(const InputNode& node);

/// The entry of a list that one part of a path means: its number, from 0, or else its `name`; nullptr if there is none.
const InputNode* entry_of_list(const InputNode& list, std::string_view part);

/// A change of the input from the command line: --set KEY.PATH=VALUE. Numbers in the path count list entries from 0;
/// entries with a `name` answer to it, too.
struct Override {
  std::string path;
  std::string value;
};

/// The value alone. Throws InputError, whose place is the option as it was typed.
InputNode value_of(const Override& change);

/// Sets the value (YAML text) at the path, making sections that are missing. Locations of what it sets: "--set
/// PATH=VALUE".
void apply_override(const Override& change, InputNode& root, Diagnostics& diagnostics);

/// The tree as YAML text that parse_yaml reads back.
std::string to_yaml(const InputNode& root);
/// The same in one line: `5 ms`, `[0, 0, 1]`.
std::string flow_text(const InputNode& node);

}  // namespace pliant
