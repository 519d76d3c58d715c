#include "mesh/script_commands.hpp"

#include "base/error.hpp"
#include "mesh/serial_mesh.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

using Words = std::vector<std::string_view>;

struct Command {
  std::string_view word, does;
};

constexpr std::array<Command, 12> commands{{{"SystemCall", "runs a program"},
                                            {"System", "runs a program"},
                                            {"NonBlockingSystemCall", "runs a program"},
                                            {"OnelabRun", "runs a program"},
                                            {"ExternalProcess", "runs a program"},
                                            {"SendToServer", "runs a program"},
                                            {"Save", "writes a file"},
                                            {"Print", "writes a file"},
                                            {"CreateDir", "writes a file"},
                                            {"Plugin", "can write files"},
                                            {"StringToName", "can turn a text into a command"},
                                            {"S2N", "can turn a text into a command"}}};

const Words loading{"Include", "Merge", "MergeWithBoundingBox"};
// What they return depends on more than the files.
const Words asking{"GetEnv",       "GetString",
                   "GetNumber",    "Today",
                   "Cpu",          "Memory",
                   "TotalMemory",  "Rand",
                   "FileExists",   "Exists",
                   "CurrentDir",   "CurrentDirectory",
                   "AbsolutePath", "GmshExecutableName",
                   "OnelabAction"};
const Words printing{"Printf", "Warning", "Error"};
const Words skipping{"If", "ElseIf", "Else", "For", "Macro", "Function"};
const Words ending{"EndIf", "ElseIf", "Else", "EndFor", "Return"};

// Extensions by which gmsh recognises formats that are not scripts, with the capitals that it recognises.
const Words other_formats{".stl", ".STL",  ".step", ".STEP", ".stp", ".STP", ".brep",
                          ".brp", ".BREP", ".iges", ".IGES", ".igs", ".IGS"};

bool is_one_of(const Words& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

enum class TokenKind { word, text, symbol };

struct Token {
  TokenKind kind = TokenKind::symbol;
  std::string_view text;
  std::size_t at = 0;  ///< byte offset in the file
};

bool begins_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_of_word(char c) {
  return begins_word(c) || (c >= '0' && c <= '9');
}

/// A script divided as gmsh's scanner does (Parser/Gmsh.l): comments of both kinds, texts in quotes of both kinds
/// without escapes, words.
struct Script {
  std::vector<Token> tokens;
  std::vector<std::string_view> asides;  ///< contents of comments and texts
  std::size_t longest_text = 0;
};

std::size_t end_of(std::string_view script, std::string_view mark, std::size_t from) {
  const std::size_t at = script.find(mark, from);
  return at == std::string_view::npos ? script.size() : at;
}

std::size_t end_of_word(std::string_view script, std::size_t at) {
  while (at < script.size() && is_of_word(script[at])) ++at;
  return at;
}

Script divided(std::string_view script) {
  Script result;
  for (std::size_t at = 0; at < script.size();) {
    const char c = script[at];
    const std::string_view two = script.substr(at, 2);
    if (two == "//" || two == "/*") {
      const std::string_view mark = two == "//" ? "\n" : "*/";
      const std::size_t end = end_of(script, mark, at + 2);
      result.asides.push_back(script.substr(at, end - at));
      at = end + mark.size();
    } else if (c == '"' || c == '\'') {
      const std::size_t end = end_of(script, script.substr(at, 1), at + 1);
      const std::string_view text = script.substr(at + 1, end - at - 1);
      result.tokens.push_back({TokenKind::text, text, at});
      result.asides.push_back(text);
      result.longest_text = std::max(result.longest_text, text.size());
      at = end + 1;
    } else if (begins_word(c)) {
      const std::size_t end = end_of_word(script, at);
      result.tokens.push_back({TokenKind::word, script.substr(at, end - at), at});
      at = end;
    } else {
      if (c != ' ' && c != '\t' && c != '\n' && c != '\r' && c != '\f') {
        result.tokens.push_back({TokenKind::symbol, script.substr(at, 1), at});
      }
      ++at;
    }
  }
  return result;
}

/// All words, including those in comments and texts.
std::vector<Token> all_words(std::string_view script) {
  std::vector<Token> words;
  for (std::size_t at = 0; at < script.size();) {
    const std::size_t end = end_of_word(script, at);
    if (end > at && begins_word(script[at])) words.push_back({TokenKind::word, script.substr(at, end - at), at});
    at = std::max(end, at + 1);
  }
  return words;
}

/// gmsh skips inactive code (If, Macro, For) with a second scanner that misreads the marks of comments and quotes: it
/// can be made to find the end of the skipped code, and to continue, within a comment or a text.
bool may_run_asides(const Script& script) {
  const auto skips = [](const Token& t) { return t.kind == TokenKind::word && is_one_of(skipping, t.text); };
  const auto has_end = [](std::string_view aside) {
    return std::ranges::any_of(all_words(aside), [](const Token& word) { return is_one_of(ending, word.text); });
  };
  return std::ranges::any_of(script.tokens, skips) && std::ranges::any_of(script.asides, has_end);
}

class Examination {
 public:
  /// `place`: empty for the file that the input names, which the message names anyway.
  void examine(const std::filesystem::path& file, const std::string& place) {
    std::error_code error;
    const auto canonical = std::filesystem::weakly_canonical(file, error);
    if (!seen_.insert(canonical.string()).second) return;
    if (!std::filesystem::is_regular_file(file, error)) return;  // gmsh reports what it cannot load
    loaded_.files.push_back(canonical);
    if (!is_one_of(other_formats, file.extension().string())) examine_script(file, place);
    const std::string options = file.string() + ".opt";
    examine(options, place.empty() ? "in '" + options + "', which gmsh loads too, " : place);
  }

  std::vector<std::string> take_reasons() { return std::move(reasons_); }
  LoadedFiles take_loaded() { return std::move(loaded_); }

 private:
  void examine_script(const std::filesystem::path& file, const std::string& place) {
    std::ifstream stream(file, std::ios::binary);
    if (stream.peek() == '$') return;  // a mesh or its data: gmsh decides by the first line
    const std::string script{std::istreambuf_iterator<char>(stream), {}};
    if (script.find('\0') != std::string::npos || script.starts_with("\x1f\x8b")) {
      reasons_.push_back(place + "it is not a text file: it is compressed, or damaged");
      return;
    }
    const Script parts = divided(script);
    constexpr std::size_t longest_text =
        1000;  // gmsh reads what is beyond the first 1023 bytes of a text as statements
    if (parts.longest_text > longest_text) {
      reasons_.push_back(place + "it has a text in quotes of more than 1000 bytes, which gmsh cannot read");
    }
    const auto told = [&](const Token& token, const std::string& what) {
      const std::string_view before = std::string_view(script).substr(0, token.at);
      const auto line = 1 + std::ranges::count(before, '\n');
      const std::size_t column = token.at - (before.rfind('\n') + 1) + 1;  // npos + 1 is 0
      reasons_.push_back(fmt::format("{}line {}, column {}: {}", place, line, column, what));
    };
    find_commands(parts.tokens, told);
    const auto asks = [](const Token& t) { return t.kind == TokenKind::word && is_one_of(asking, t.text); };
    if (std::ranges::any_of(parts.tokens, asks)) loaded_.is_all = false;
    if (may_run_asides(parts)) {
      for (const Token& word : all_words(script)) {
        const auto is_told = [&](const Token& t) { return t.at == word.at && t.kind == TokenKind::word; };
        if (std::ranges::none_of(parts.tokens, is_told)) tell_command(word, told, " even in a comment or a text");
      }
    }
    follow(parts.tokens, file, told);
  }

  template <class Tell>
  static void tell_command(const Token& word, const Tell& tell, std::string_view where = "") {
    for (const auto& command : commands) {
      if (command.word == word.text) tell(word, fmt::format("'{}' {}{}", word.text, command.does, where));
    }
  }

  template <class Tell>
  static void find_commands(const std::vector<Token>& tokens, const Tell& tell) {
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      if (tokens[i].kind != TokenKind::word) continue;
      const bool is_option = (i > 0 && tokens[i - 1].text == "." && tokens[i - 1].kind == TokenKind::symbol) ||
                             (i + 1 < tokens.size() && tokens[i + 1].text == ".");
      if (!is_option) tell_command(tokens[i], tell);
      if (is_one_of(printing, tokens[i].text) && is_redirected(tokens, i)) {
        tell(tokens[i], fmt::format("'{} ... >' writes a file", tokens[i].text));
      }
    }
  }

  /// Whether a `>` follows outside the parentheses, before the statement ends.
  static bool is_redirected(const std::vector<Token>& tokens, std::size_t i) {
    int depth = 0;
    for (++i; i < tokens.size(); ++i) {
      if (tokens[i].kind != TokenKind::symbol) continue;
      const char c = tokens[i].text[0];
      if (c == ';') return false;
      if (c == '(' || c == '[') ++depth;
      if (c == ')' || c == ']') --depth;
      if (c == '>' && depth == 0) return true;
    }
    return false;
  }

  template <class Tell>
  void follow(const std::vector<Token>& tokens, const std::filesystem::path& file, const Tell& tell) {
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      if (tokens[i].kind != TokenKind::word || !is_one_of(loading, tokens[i].text)) continue;
      const bool is_plain = i + 2 < tokens.size() && tokens[i + 1].kind == TokenKind::text && tokens[i + 2].text == ";";
      if (!is_plain) {
        tell(tokens[i], fmt::format("'{}' loads a file whose name is not a plain text in quotes, so it cannot be "
                                    "searched for commands",
                                    tokens[i].text));
        continue;
      }
      const std::string loaded(tokens[i + 1].text);
      examine(file.parent_path() / loaded, "in '" + loaded + "', which it loads, ");
    }
  }

  std::set<std::string> seen_;
  std::vector<std::string> reasons_;
  LoadedFiles loaded_;
};

}  // namespace

LoadedFiles require_no_commands(const std::string& file) {
  Examination examination;
  examination.examine(file, "");
  std::vector<std::string> reasons = examination.take_reasons();
  if (reasons.empty()) return examination.take_loaded();
  constexpr std::size_t shown = 5;
  if (reasons.size() > shown) {
    reasons.at(shown - 1) += fmt::format(" (and {} more such places)", reasons.size() - shown);
    reasons.resize(shown);
  }
  reasons.back() +=
      "; take it out, or, if you trust the file, set 'mesh.allow_commands: true' (`pliant mesh convert` has "
      "--allow-commands)";
  throw MeshDefect(reasons);
}

}  // namespace pliant
