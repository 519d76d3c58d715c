#include "input/parse.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <sstream>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

namespace pliant {
namespace {

constexpr std::size_t max_bytes = 4u << 20;
constexpr std::size_t max_nodes = 50'000;
constexpr std::size_t max_depth = 32;

std::string megabytes() {
  return std::to_string(max_bytes >> 20) + " MB";
}

/// Line and column of a byte of the text.
Location place_of(const std::string& text, std::size_t at, const std::string& file) {
  const std::size_t line_start = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;  // npos + 1 == 0
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
  return {file, static_cast<int>(line), static_cast<int>(at - line_start + 1)};
}

void check_is_text(const std::string& text, const std::string& file) {
  if (text.size() > max_bytes) {
    throw InputError({file, 0, 0}, "the input is larger than " + megabytes() + "; is this the right file?");
  }
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw InputError({file, 0, 0}, "the file is in UTF-16; save it as UTF-8");
  }
  if (const auto bad = first_invalid_utf8(text)) {
    throw InputError(place_of(text, *bad, file), "this is not UTF-8 text; is this the right file, saved as UTF-8?");
  }
  const auto control = std::find_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\r' && c != '\t') || c == 0x7F;
  });
  if (control != text.end()) {
    throw InputError(place_of(text, static_cast<std::size_t>(control - text.begin()), file),
                     "the file contains a control character; is this a text file?");
  }
}

/// Does the quoted scalar that starts at `at` end? yaml-cpp takes the end of the file for its end.
bool quote_is_closed(const std::string& text, std::size_t at) {
  const char quote = text[at];
  for (std::size_t i = at + 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;
    } else if (text[i] == quote) {
      if (quote == '"' || i + 1 >= text.size() || text[i + 1] != '\'') return true;
      ++i;
    }
  }
  return false;
}

/// Builds the tree from yaml-cpp's events; throws InputError through the parser where it makes no sense to continue.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& text, const std::string& file, Diagnostics& diagnostics)
      : text_(text), file_(file), diagnostics_(diagnostics) {}

  InputNode root() && { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) {
      throw InputError(at(mark), std::string(several_documents));
    }
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    InputNode null = node(InputNode::Kind::null, mark);
    const auto start = static_cast<std::size_t>(mark.pos);
    if (start < text_.size() && std::string_view("nN~").find(text_[start]) != std::string_view::npos)
      null.text = "null";
    finish(std::move(null), anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_own(tag, mark);
    InputNode scalar = node(InputNode::Kind::scalar, mark);
    scalar.text = value;
    if (tag == "!") scalar.style = InputNode::Style::quoted;
    const auto start = static_cast<std::size_t>(mark.pos);
    if (tag == "!" && start < text_.size() && (text_[start] == '"' || text_[start] == '\'') &&
        !quote_is_closed(text_, start)) {
      throw InputError(at(mark), "this quote is not closed");
    }
    finish(std::move(scalar), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchors_.find(anchor);
    if (known == anchors_.end()) throw InputError(at(mark), "this alias refers to a value that contains it");
    InputNode copy = known->second.node;
    count(mark, known->second.size);
    copy.key.clear();
    finish(std::move(copy), 0);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    refuse_own(tag, mark);
    start(InputNode::Kind::list, mark, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    refuse_own(tag, mark);
    start(InputNode::Kind::map, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    InputNode node;
    YAML::anchor_t anchor;
    std::optional<InputNode> key;   // map: read, its value not yet
    std::vector<InputNode> merged;  // map: values of "<<"
    std::size_t first;              // number of nodes before this one
  };
  struct Anchored {
    InputNode node;
    std::size_t size;
  };

  Location at(const YAML::Mark& mark) const { return {file_, mark.line + 1, mark.column + 1}; }

  /// Tags of other programs, such as '!include', would have no effect here and are errors. YAML's own, such as '!!str',
  /// are ignored.
  void refuse_own(const std::string& tag, const YAML::Mark& mark) const {
    if (tag.size() > 1 && tag.front() == '!')
      throw InputError(at(mark), "tags such as '" + excerpt(tag) + "' are not supported; leave it out");
  }

  void count(const YAML::Mark& mark, std::size_t more) {
    num_nodes_ += more;
    if (num_nodes_ > max_nodes) {
      throw InputError(at(mark),
                       "the input has more than " + std::to_string(max_nodes) + " values; is this the right file?");
    }
  }

  InputNode node(InputNode::Kind kind, const YAML::Mark& mark) {
    count(mark, 1);
    InputNode result;
    result.kind = kind;
    result.where = at(mark);
    return result;
  }

  void start(InputNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    const std::size_t first = num_nodes_;
    if (open_.size() >= max_depth) throw InputError(at(mark), "the input is nested too deeply");
    open_.push_back({node(kind, mark), anchor, {}, {}, first});
  }

  void close() {
    Open closed = std::move(open_.back());
    open_.pop_back();
    for (InputNode& source : closed.merged) merge(std::move(source), closed.node);
    last_size_ = num_nodes_ - closed.first;
    finish(std::move(closed.node), closed.anchor);
  }

  /// YAML's merge key: entries that the map does not have itself.
  void merge(InputNode source, InputNode& into) {
    if (source.kind == InputNode::Kind::list) {
      for (InputNode& item : source.children) merge(std::move(item), into);
      return;
    }
    if (source.kind != InputNode::Kind::map) {
      diagnostics_.add(source.where, "'<<' needs a map of keys, not " + description(source));
      return;
    }
    for (InputNode& entry : source.children) {
      if (into.find(entry.key) == nullptr) into.children.push_back(std::move(entry));
    }
  }

  /// Puts a complete value where it belongs.
  void finish(InputNode value, YAML::anchor_t anchor) {
    if (anchor != 0) {
      const bool leaf = value.kind == InputNode::Kind::null || value.kind == InputNode::Kind::scalar;
      const std::size_t size = leaf ? 1 : last_size_;
      num_nodes_ += size;  // the copy kept here; nested anchors multiply
      anchors_[anchor] = {value, size};
    }
    if (open_.empty()) {
      root_ = std::move(value);
    } else if (open_.back().node.kind == InputNode::Kind::list) {
      open_.back().node.children.push_back(std::move(value));
    } else if (!open_.back().key) {
      open_.back().key = std::move(value);
    } else {
      add_entry(open_.back(), std::move(value));
    }
  }

  void add_entry(Open& map, InputNode value) {
    const InputNode key = *std::exchange(map.key, std::nullopt);
    if (key.kind != InputNode::Kind::scalar) {
      diagnostics_.add(key.where, "a key must be a word, not " + description(key));
      return;
    }
    if (key.text == "<<" && key.style == InputNode::Style::plain) {
      map.merged.push_back(std::move(value));
      return;
    }
    if (const InputNode* first = map.node.find(key.text)) {
      diagnostics_.add(key.where, "key '" + excerpt(key.text) + "' is given twice (first in line " +
                                      std::to_string(first->key_where.line) + ")");
      return;
    }
    value.key = key.text;
    value.key_where = key.where;
    map.node.children.push_back(std::move(value));
  }

  const std::string& text_;
  const std::string& file_;
  Diagnostics& diagnostics_;
  int documents_ = 0;
  std::size_t num_nodes_ = 0;
  std::size_t last_size_ = 1;  // nodes in the value that was closed last
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  InputNode root_;
};

/// yaml-cpp's messages in words that say what to do.
std::string plain_words(const std::string& message) {
  struct Translation {
    std::string_view theirs, ours;
  };
  static constexpr std::array translations{
      Translation{"illegal map value",
                  "':' is not expected here; check the indentation, and quote text that contains ': '"},
      Translation{"illegal block entry", "a list entry '- ' is not expected here; start it on a line of its own"},
      Translation{"end of sequence flow not found", "a ']' is missing in the list before this place"},
      Translation{"end of map flow not found", "a '}' is missing in the map before this place"},
      Translation{"illegal flow end", "this bracket was never opened"},
      Translation{"unknown token", "text cannot start with this character; put it in quotes"},
      Translation{
          "the referenced anchor is not defined",
          "this alias refers to an anchor ('&name') that is not defined before; a formula that begins with '*' needs "
          "quotes"},
      Translation{"end of map not found", "this line does not belong to the keys above; check the indentation"},
      Translation{"end of sequence not found", "this line does not belong to the list above; check the indentation"},
  };
  for (const auto& t : translations) {
    if (message == t.theirs) return std::string(t.ours);
  }
  return message;
}

/// Is line `line` (from 1) indented with a tab, which YAML forbids and yaml-cpp explains badly?
std::optional<int> column_of_tab(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string content;
  for (int i = 0; i < line; ++i) {
    if (!std::getline(lines, content)) return {};
  }
  const std::size_t indent = std::min(content.find_first_not_of(" \t"), content.size());
  const std::size_t tab = content.find('\t');
  return tab < indent ? std::optional(static_cast<int>(tab) + 1) : std::nullopt;
}

/// The bracket of the text that is not closed, or not by its counterpart: the first such place. Nothing if there is
/// none, or if a quote is not closed.
std::optional<std::size_t> unclosed_bracket(const std::string& text) {
  std::vector<std::size_t> open;  // positions of brackets
  bool begins = true;             // whether a value or a key may begin at the next character that is not blank
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    const bool follows_blank = at == 0 || std::isspace(static_cast<unsigned char>(text[at - 1])) != 0;
    if (c == '#' && follows_blank) {
      at = std::min(text.find('\n', at), text.size()) - 1;
    } else if ((c == '"' || c == '\'') && begins) {
      for (++at; at < text.size(); ++at) {
        const bool is_doubled = c == '\'' && text[at] == c && text.substr(at + 1, 1) == "'";  // a quote in the text
        if (text[at] == c && !is_doubled) break;
        if (is_doubled || (c == '"' && text[at] == '\\')) ++at;
      }
      if (at >= text.size()) return {};
      begins = false;
    } else if ((c == '[' || c == '{') && (begins || !open.empty())) {
      open.push_back(at);
      begins = true;
    } else if ((c == ']' || c == '}') && !open.empty()) {
      if ((text[open.back()] == '[') != (c == ']')) return open.back();
      open.pop_back();
      begins = false;
    } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
      begins = begins || c == '\n';
    } else {
      const bool ends_word = at + 1 == text.size() || std::isspace(static_cast<unsigned char>(text[at + 1])) != 0;
      begins = (c == ',' && !open.empty()) || ((c == ':' || (c == '-' && begins)) && ends_word);
    }
  }
  return open.empty() ? std::nullopt : std::optional(open.back());
}

InputError syntax_error(const YAML::Exception& error, const std::string& text, const std::string& file) {
  const Location where{file, error.mark.line + 1, error.mark.column + 1};
  if (const auto column = column_of_tab(text, where.line)) {
    return {{file, where.line, *column}, "tabs cannot indent YAML; use spaces"};
  }
  if (const auto bracket = unclosed_bracket(text)) {
    const auto line = 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(*bracket), '\n'));
    const std::size_t begin = *bracket == 0 ? 0 : text.rfind('\n', *bracket - 1) + 1;  // 0 without a line before
    if (line <= where.line) {
      return {{file, line, static_cast<int>(*bracket - begin) + 1},
              fmt::format("not valid YAML: the '{}' is not closed", text[*bracket])};
    }
  }
  return {where, "not valid YAML: " + plain_words(error.msg)};
}

}  // namespace

InputNode parse_yaml(const std::string& text, const std::string& file, Diagnostics& diagnostics) {
  check_is_text(text, file);
  const std::string body = text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
  TreeBuilder builder(body, file, diagnostics);
  std::istringstream stream(body);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    throw syntax_error(error, body, file);
  }
  return std::move(builder).root();
}

}  // namespace pliant
