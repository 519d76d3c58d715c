#include "input/tree.hpp"

#include "base/text.hpp"
#include "input/parse.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <tuple>

namespace pliant {
namespace {

constexpr std::size_t max_reported = 50;
constexpr std::size_t max_path = 16;

void relocate(InputNode& node, const Location& where) {
  node.where = node.key_where = where;
  for (InputNode& child : node.children) relocate(child, where);
}

/// The entry that one part of an override's path names; nullptr after an error.
InputNode* entry_of(InputNode& node, const std::string& part, const Location& where, Diagnostics& diagnostics) {
  using Kind = InputNode::Kind;
  if (node.kind == Kind::list) {
    if (const InputNode* const found = entry_of_list(node, part)) return &node.children[found - node.children.data()];
    const std::size_t size = node.children.size();
    std::string names;
    for (std::size_t k = 0; k < size; ++k) {
      const InputNode& child = node.children[k];
      const InputNode* const name = child.find("name");
      const InputNode* const volume = child.find("volume");
      const bool is_meant = name == nullptr && volume != nullptr && volume->text == part;
      if (is_meant) names = "; number " + std::to_string(k) + " has the volume " + excerpt(part) + names;
      if (name != nullptr) names += (names.empty() ? "; their names: " : ", ") + excerpt(name->text);
    }
    diagnostics.add(where, "'" + excerpt(part) + "' does not name an entry of this list" +
                               (size == 0   ? ", which is empty"
                                : size == 1 ? "; its only entry has the number 0" + names
                                            : "; they are numbered from 0 to " + std::to_string(size - 1) + names));
    return nullptr;
  }
  if (node.kind == Kind::scalar) {
    diagnostics.add(where, "there is no key '" + excerpt(part) + "' in the value '" + excerpt(node.text) + "'");
    return nullptr;
  }
  node.kind = Kind::map;
  for (InputNode& child : node.children) {
    if (child.key == part) return &child;
  }
  node.children.push_back({});
  node.children.back().key = part;
  relocate(node.children.back(), where);
  return &node.children.back();
}

bool is_plain_word(const std::string& text) {
  static constexpr std::array reserved{"null", "true", "false", "yes", "no", "on", "off"};
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto is_word = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return !text.empty() && is_letter(text.front()) && std::all_of(text.begin(), text.end(), is_word) &&
         std::none_of(reserved.begin(), reserved.end(),
                      [&](const char* word) { return edit_distance(text, word) == 0; });
}

std::string scalar_text(const InputNode& node) {
  if (node.kind == InputNode::Kind::null) return "null";
  if (node.style == InputNode::Style::word) return node.text;
  if (node.style == InputNode::Style::plain && (is_plain_word(node.text) || parse_number(node.text))) return node.text;
  std::string quoted = "\"";
  for (char c : node.text) {
    switch (c) {
      case '"':
        quoted += "\\\"";
        break;
      case '\\':
        quoted += "\\\\";
        break;
      case '\n':
        quoted += "\\n";
        break;
      case '\r':
        quoted += "\\r";
        break;
      case '\t':
        quoted += "\\t";
        break;
      default:
        quoted += c;
    }
  }
  return quoted + '"';
}

bool is_leaf(const InputNode& node) {
  return node.kind == InputNode::Kind::null || node.kind == InputNode::Kind::scalar || node.children.empty();
}

bool has_map(const InputNode& node) {
  return node.kind == InputNode::Kind::map || std::any_of(node.children.begin(), node.children.end(), has_map);
}

std::string block_text(const InputNode& node, const std::string& indent) {
  std::string out;
  for (const InputNode& child : node.children) {
    if (node.kind == InputNode::Kind::list) {
      const bool is_block = child.kind == InputNode::Kind::map && !is_leaf(child);
      std::string entry = is_block ? block_text(child, indent + "  ") : indent + "  " + flow_text(child) + '\n';
      out += entry.replace(indent.size(), 2, "- ");
    } else if (is_leaf(child) || !has_map(child)) {
      out += indent + child.key + ": " + flow_text(child) + '\n';
    } else {
      out += indent + child.key + ":\n" + block_text(child, indent + "  ");
    }
  }
  return out;
}

}  // namespace

bool Diagnostics::is_wrong(const Lack& lack) const {
  return std::ranges::any_of(lack.keys, [&](const std::string& key) {
    return wrong_.count({to_string(lack.section), key}) > 0;
  });
}

void Diagnostics::throw_if_errors() const {
  std::vector<Diagnostic> errors;
  for (const Error& error : found_) {
    if (!is_wrong(error.lack)) errors.push_back(error.diagnostic);
  }
  if (errors.empty()) return;
  const auto order = [](const Diagnostic& d) { return std::tie(d.where.line, d.where.column); };
  const auto same = [&](const Diagnostic& a, const Diagnostic& b) {
    return order(a) == order(b) && a.where.file == b.where.file && a.message == b.message;
  };
  std::stable_sort(errors.begin(), errors.end(), [&](const auto& a, const auto& b) { return order(a) < order(b); });
  errors.erase(std::unique(errors.begin(), errors.end(), same), errors.end());  // aliases repeat theirs
  if (errors.size() > max_reported) {
    const std::size_t more = errors.size() - max_reported;
    errors.resize(max_reported);
    errors.push_back(
        {Severity::error, {errors.front().where.file, 0, 0}, "... and " + std::to_string(more) + " more errors"});
  }
  throw InputError(std::move(errors));
}

InputNode InputNode::scalar(std::string text) {
  InputNode node;
  node.kind = Kind::scalar;
  node.text = std::move(text);
  return node;
}

InputNode InputNode::list(std::vector<InputNode> items) {
  InputNode node;
  node.kind = Kind::list;
  node.children = std::move(items);
  return node;
}

InputNode InputNode::map(std::vector<InputNode> entries) {
  InputNode node = list(std::move(entries));
  node.kind = Kind::map;
  return node;
}

InputNode InputNode::under(std::string new_key) && {
  key = std::move(new_key);
  return std::move(*this);
}

const InputNode* InputNode::find(std::string_view name) const {
  if (kind != Kind::map) return nullptr;
  const auto found = std::find_if(children.begin(), children.end(), [&](const InputNode& c) { return c.key == name; });
  return found == children.end() ? nullptr : &*found;
}

const InputNode* entry_of_list(const InputNode& list, std::string_view part) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (error == std::errc{} && end == part.data() + part.size()) {
    return index < list.children.size() ? &list.children[index] : nullptr;
  }
  const auto found = std::ranges::find_if(list.children, [&](const InputNode& child) {
    const InputNode* const name = child.find("name");
    return name != nullptr && name->text == part;
  });
  return found == list.children.end() ? nullptr : &*found;
}

const InputNode* given(const InputNode& root, std::initializer_list<std::string_view> path) {
  const InputNode* node = &root;
  for (const std::string_view key : path) {
    node = node->find(key);
    if (node == nullptr || node->kind == InputNode::Kind::null) return nullptr;
  }
  return node;
}

std::string description(const InputNode& node) {
  switch (node.kind) {
    case InputNode::Kind::null:
      return "empty";
    case InputNode::Kind::list:
      return node.children.empty() ? "an empty list" : "a list";
    case InputNode::Kind::map:
      return "a map of keys";
    default:
      return "'" + excerpt(node.text) + "'";
  }
}

InputNode value_of(const Override& change) {
  const Location where{"--set " + change.path + "=" + change.value, 0, 0};
  Diagnostics diagnostics;
  try {
    InputNode value = parse_yaml(change.value, where.file, diagnostics);
    diagnostics.throw_if_errors();
    return value;
  } catch (const InputError& error) {
    std::vector<Diagnostic> errors = error.diagnostics();
    const bool continues = change.value.starts_with('[') || change.value.starts_with('{');
    for (Diagnostic& d : errors) {
      d.where = where;
      if (continues && d.message == several_documents) d.message = "there is text after the closing bracket";
    }
    throw InputError(std::move(errors));
  }
}

void apply_override(const Override& change, InputNode& root, Diagnostics& diagnostics) {
  const Location where{"--set " + change.path + "=" + change.value, 0, 0};
  InputNode value;
  try {
    value = value_of(change);
  } catch (const InputError& error) {
    for (const Diagnostic& d : error.diagnostics()) diagnostics.add(where, d.message);
    return;
  }
  if (change.path.find('[') != std::string::npos) {
    diagnostics.add(where, "entries of lists are numbers after dots, such as bodies.0.density");
    return;
  }
  InputNode* node = &root;
  std::istringstream path(change.path + '.');
  std::size_t depth = 0;
  for (std::string part; std::getline(path, part, '.');) {
    if (part.empty() || ++depth > max_path) {
      diagnostics.add(where, "the path must be keys separated by dots, such as time.step or bodies.0.density");
      return;
    }
    node = entry_of(*node, part, where, diagnostics);
    if (node == nullptr) return;
  }
  value.key = node->key;
  relocate(value, where);
  *node = std::move(value);
}

std::string flow_text(const InputNode& node) {
  if (node.kind != InputNode::Kind::list && node.kind != InputNode::Kind::map) return scalar_text(node);
  const bool is_map = node.kind == InputNode::Kind::map;
  std::string text;
  for (const InputNode& child : node.children) {
    text += (text.empty() ? "" : ", ") + (is_map ? child.key + ": " : "") + flow_text(child);
  }
  return is_map ? '{' + text + '}' : '[' + text + ']';
}

std::string to_yaml(const InputNode& root) {
  return block_text(root, "");
}

}  // namespace pliant
