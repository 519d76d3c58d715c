#include "study/varied_input.hpp"

#include "base/text.hpp"
#include "base/units.hpp"
#include "input/keys.hpp"
#include "input/parse.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Sections on which the mesh, the steps or the files depend, not the mechanics.
constexpr std::array<std::string_view, 6> other_sections{"mesh", "time", "solver", "output", "checkpoint", "element"};

/// Keys of a rod from which its nodes follow.
constexpr std::array<std::string_view, 4> geometry_of_rods{"radius", "width", "height", "points"};

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream stream(path);
  for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
  return parts;
}

const InputNode* entry(const InputNode& node, const std::string& part) {
  return node.kind == InputNode::Kind::list ? entry_of_list(node, part) : node.find(part);
}

/// The description of the key at the end of the path; nullptr where the table knows none.
const KeyInfo* key_info(const std::vector<std::string>& parts) {
  const std::vector<KeyInfo>* among = &input_keys();
  const KeyInfo* found = nullptr;
  bool may_be_name = false;  // of an entry of a list
  for (const std::string& part : parts) {
    const bool is_index = part.find_first_not_of("0123456789") == std::string::npos;
    if (is_index) continue;
    const auto key = std::ranges::find(*among, part, &KeyInfo::key);
    if (key == among->end() && found != nullptr && std::exchange(may_be_name, false)) continue;
    if (key == among->end()) return nullptr;
    may_be_name = true;
    found = &*key;
    among = &key->children.all();
  }
  return found;
}

/// The unit in what the table says of the key: "pressure [Pa] or formula of t", "place `[x, y, z]` [m]".
std::string unit_of(const KeyInfo* info) {
  if (info == nullptr) return "1";
  const std::string& type = info->type;
  for (std::size_t open = type.find('['); open != std::string::npos; open = type.find('[', open + 1)) {
    const std::size_t end = type.find_first_of("[],", open + 1);
    if (end != std::string::npos && type[end] == ']') return type.substr(open + 1, end - open - 1);
  }
  return "1";  // there is none, or only components: "direction [x, y, z]"
}

const InputNode* node_at(const InputNode& tree, const std::vector<std::string>& parts) {
  const InputNode* node = &tree;
  for (const std::string& part : parts) {
    node = entry(*node, part);
    if (node == nullptr) return nullptr;
  }
  return node;
}

/// The value in SI; nothing if it is another thing than a single number.
std::optional<double> number_of(const InputNode& node, const std::string& unit) {
  if (node.kind != InputNode::Kind::scalar) return std::nullopt;
  try {
    return parse_quantity(node.text, unit);
  } catch (const UnitError&) {
    return std::nullopt;
  }
}

bool is_of_other_sections(const std::vector<std::string>& parts) {
  return !parts.empty() && std::ranges::find(other_sections, parts.front()) != other_sections.end();
}

/// Keys of the numbers at or below a node that may be varied. Entries of lists go by the names that `key` has.
void add_numbers_below(const InputNode& node, const std::string& path, const std::string& key,
                       std::vector<std::string>& paths) {
  const auto parts = parts_of(path);
  if (is_of_other_sections(parts)) return;
  if (number_of(node, unit_of(key_info(parts)))) paths.push_back(path);
  for (std::size_t k = 0; k < node.children.size(); ++k) {
    const InputNode& child = node.children[k];
    const InputNode* name = node.kind == InputNode::Kind::list ? child.find("name") : nullptr;
    const bool is_by_name = name != nullptr && key.find('.' + name->text) != std::string::npos;
    const std::string part = is_by_name                           ? name->text
                             : node.kind == InputNode::Kind::list ? std::to_string(k)
                                                                  : child.key;
    add_numbers_below(child, path.empty() ? part : path + '.' + part, key, paths);
  }
}

/// `as_typed`: the user's tree, `as_read`: with all defaults, perhaps in another form.
VariedNumber number_at(const InputNode& as_typed, const InputNode& as_read, const std::string& key,
                       const Location& where) {
  const auto parts = parts_of(key);
  if (is_of_other_sections(parts)) {
    throw InputError(where, fmt::format("'{}' cannot be varied: mesh, steps and files must be the same for all values; "
                                        "numbers of bodies, loads, constraints or contact can",
                                        key));
  }
  const auto is_geometry = [](const std::string& part) {
    return std::ranges::find(geometry_of_rods, part) != geometry_of_rods.end();
  };
  if (!parts.empty() && parts.front() == "rods" && std::ranges::any_of(parts, is_geometry)) {
    throw InputError(where, fmt::format("'{}' cannot be varied: the nodes of a rod follow from its points and its "
                                        "section, and the mesh must be the same for all values; compare runs instead "
                                        "(`pliant sweep`)",
                                        key));
  }
  const InputNode* node = node_at(as_typed, parts);
  if (node == nullptr) node = node_at(as_read, parts);
  if (node == nullptr) {
    std::vector<std::string> known;
    add_numbers_below(as_read, "", key, known);
    throw InputError(where, fmt::format("the input has no '{}'{}; name a number as --set does, such as "
                                        "bodies.0.density; `run.yaml` of a run lists all",
                                        key, did_you_mean(key, known)));
  }
  const KeyInfo* info = key_info(parts);
  const bool is_counted = info != nullptr && info->type.starts_with("whole number");
  const std::string unit = unit_of(info);
  const auto value = is_counted ? std::nullopt : number_of(*node, unit);
  if (!value) {
    throw InputError(where, fmt::format("'{}' is {}; only single numbers that may change by little can be varied", key,
                                        is_counted ? "a " + info->type : description(*node)));
  }
  return {key, *value, unit};
}

}  // namespace

std::string unit_of_key(const std::string& key) {
  return unit_of(key_info(parts_of(key)));
}

VariedInput::VariedInput(std::string text, std::string file, std::vector<Override> changes,
                         const std::vector<std::string>& keys, const std::string& option)
    : text_(std::move(text)),
      file_(std::move(file)),
      changes_(std::move(changes)),
      given_(read_input(text_, file_, changes_)) {
  Diagnostics ignored;
  InputNode as_typed = parse_yaml(text_, file_, ignored);
  for (const Override& change : changes_) apply_override(change, as_typed, ignored);
  const InputNode as_read = write_config(given_);
  for (const std::string& key : keys) {
    const Location where{option, 0, 0};
    if (std::ranges::find(numbers_, key, &VariedNumber::key) != numbers_.end()) {
      throw InputError(where, fmt::format("'{}' is named twice", key));
    }
    numbers_.push_back(number_at(as_typed, as_read, key, where));
  }
}

Config VariedInput::at(std::span<const double> values) const {
  std::vector<Override> changes = changes_;
  for (std::size_t n = 0; n < numbers_.size(); ++n) changes.push_back({numbers_[n].key, format_number(values[n])});
  return read_input(text_, file_, changes);
}

}  // namespace pliant
