#include "input/unknown_key.hpp"

#include "base/text.hpp"
#include "input/foreign_keys.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <optional>
#include <string_view>

namespace pliant {
namespace {

bool has_key(const std::vector<KeyInfo>& keys, const std::string& key) {
  return std::ranges::find(keys, key, &KeyInfo::key) != keys.end();
}

/// Adds the paths of all sections below that have the key, each once.
void add_owners(const std::string& key, const std::vector<KeyInfo>& keys, const std::string& path,
                std::vector<std::string>& owners) {
  for (const KeyInfo& section : keys) {
    const std::string inner = path.empty() ? section.key : path + "." + section.key;
    if (has_key(section.children, key)) owners.push_back(inner);
    add_owners(key, section.children, inner, owners);
  }
}

/// Where a key that a section does not have belongs: " (it belongs in ...)" for a section in it, or the whole file;
/// else " (it is a key of ...)" for one or two other sections; else empty.
std::string where_it_belongs(const std::string& key, const KeyInfo& section, const KeyInfo* file) {
  std::vector<std::string> inner;
  for (const KeyInfo& one : section.children) {
    if (has_key(one.children, key)) inner.push_back(one.key);
  }
  if (!inner.empty() && inner.size() <= 3) return " (it belongs in " + joined(inner) + ")";
  if (file == nullptr) return "";
  std::vector<std::string> owners;
  add_owners(key, file->children, "", owners);
  const bool is_of_file = has_key(file->children, key);
  if (is_of_file && owners.size() != 1) return " (it belongs at the top level)";
  if (is_of_file) owners.insert(owners.begin(), "the top level");
  if (owners.empty() || owners.size() > 2) return "";
  return " (it is a key of " + owners[0] + (owners.size() > 1 ? " and of " + owners[1] : "") + ")";
}

/// What is said of a key that is a piece of another value; else empty.
std::string split_value(const InputNode& child) {
  const std::string& key = child.key;
  if (child.kind != InputNode::Kind::null) return "";
  if (is_part_of_formula(key)) {
    return "'" + excerpt(key) +
           "' is part of a formula that was split at a ','; inside { }, put the formula in quotes, such as " +
           "\"min(t, 1)\"";
  }
  if (!starts_with_digit(key)) return "";
  return "'" + excerpt(key) + "' stands alone after a ','; a decimal point is written '.'";
}

}  // namespace

std::vector<std::string> names_of(const std::vector<KeyInfo>& keys) {
  std::vector<std::string> names;
  for (const KeyInfo& key : keys) names.push_back(key.key);
  return names;
}

std::string in_section(const std::string& name) {
  return name.empty() ? "" : " in " + name;
}

bool is_given(const InputNode& node, const std::string& key) {
  const InputNode* value = node.find(key);
  return value != nullptr && value->kind != InputNode::Kind::null;
}

bool is_given(const InputNode& node, const Anchor& anchor) {
  return is_given(node, anchor.key) && (anchor.value.empty() || node.find(anchor.key)->text == anchor.value);
}

bool starts_with_digit(std::string_view text) {
  return !text.empty() && std::isdigit(static_cast<unsigned char>(text.front())) != 0;
}

std::vector<KeyInfo> usable(const InputNode& node, const KeyInfo& section) {
  const auto is_chosen = [&](const Anchor& anchor) { return is_given(node, anchor); };
  const auto is_open = [&](const Anchor& anchor) {
    return std::none_of(section.children.begin(), section.children.end(), [&](const KeyInfo& other) {
      return std::any_of(other.only_with.begin(), other.only_with.end(),
                         [&](const Anchor& a) { return a.key == anchor.key && is_given(node, a); });
    });
  };
  std::vector<KeyInfo> keys;
  std::copy_if(section.children.begin(), section.children.end(), std::back_inserter(keys), [&](const KeyInfo& key) {
    return key.only_with.empty() || is_open(key.only_with.front()) ||
           std::any_of(key.only_with.begin(), key.only_with.end(), is_chosen);
  });
  return keys;
}

std::optional<std::string> synonym_of(const std::string& key, const std::vector<KeyInfo>& keys) {
  const auto is_synonym = [&](const KeyInfo& known) {
    return std::find(known.also.begin(), known.also.end(), key) != known.also.end();
  };
  const auto found = std::find_if(keys.begin(), keys.end(), is_synonym);
  return found == keys.end() ? std::nullopt : std::optional(found->key);
}

void report_unknown_key(const InputNode& child, const std::string& section_name, const InputNode& node,
                        const KeyInfo& section, Diagnostics& diagnostics) {
  const std::string& key = child.key;
  const auto keys = usable(node, section);
  auto synonym = synonym_of(key, keys);
  if (const std::string word(key_for(key, section_name)); !synonym && has_key(keys, word)) synonym = word;
  const auto meant = synonym ? synonym : closest(key, names_of(keys));
  const bool is_slip = meant && edit_distance(key, *meant) <= 1;
  const auto belongs = where_it_belongs(key, section, diagnostics.keys_of_file());
  const bool is_elsewhere = !belongs.empty() && !synonym && !is_slip;
  const std::string message = "unknown key '" + excerpt(key) + "'" + in_section(section_name);
  if (meant && !is_elsewhere) diagnostics.note_wrong(node.where, *meant);
  if (const std::string split = split_value(child); !split.empty()) {
    diagnostics.add(child.key_where, split);
  } else if (const std::string_view instead = instead_of(key, section_name); !instead.empty()) {
    diagnostics.add(child.key_where, message + "; " + std::string(instead));
  } else if (key.find(':') != std::string::npos) {
    diagnostics.add(child.key_where, message + " (the ':' after a key must be followed by a space)");
  } else if (is_elsewhere) {
    const std::string here = belongs.starts_with(" (it belongs") ? "" : "; the keys here are " + joined(names_of(keys));
    diagnostics.add(child.key_where, message + belongs + here);
  } else if (meant) {
    diagnostics.add(child.key_where, message + " (did you mean '" + *meant + "'?)");
  } else {
    diagnostics.add(child.key_where, message + "; the keys are " + joined(names_of(keys)));
  }
}

}  // namespace pliant
