#include "input/schema.hpp"

#include "base/text.hpp"
#include "input/unknown_key.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

namespace pliant {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> given_keys(const InputNode& node, const KeyGroup& group) {
  std::vector<std::string> given;
  std::copy_if(group.keys.begin(), group.keys.end(), std::back_inserter(given),
               [&](const std::string& key) { return is_given(node, key); });
  return given;
}

/// The owner of the group's keys that is given, if any.
std::optional<Anchor> anchor_of(const InputNode& node, const KeyGroup& group) {
  const auto found = std::find_if(group.only_with.begin(), group.only_with.end(),
                                  [&](const Anchor& anchor) { return is_given(node, anchor); });
  return found == group.only_with.end() ? std::nullopt : std::optional(*found);
}

bool holds(const std::vector<std::string>& keys, const std::string& key) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

bool count_as_one(const std::vector<std::string>& keys, const KeyGroup& group) {
  return std::any_of(group.together.begin(), group.together.end(), [&](const auto& set) {
    return std::all_of(keys.begin(), keys.end(), [&](const std::string& key) { return holds(set, key); });
  });
}

void check_group(const InputNode& node, const std::string& name, const KeyGroup& group, Diagnostics& diagnostics) {
  const auto given = given_keys(node, group);
  const auto anchor = anchor_of(node, group);
  if (!group.only_with.empty() && !anchor) return;
  if (group.need == KeyGroup::Need::all) {
    for (const std::string& key : group.keys) {
      if (is_given(node, key)) continue;
      const std::string why = anchor ? ", which '" + to_string(*anchor) + "' needs" : "";
      diagnostics.add({node.where, {key}}, node.where, "missing key '" + key + "'" + in_section(name) + why);
    }
  }
  if (group.need == KeyGroup::Need::at_least_one && given.empty()) {
    diagnostics.add({node.where, group.keys}, node.where,
                    "at least one of " + joined(group.keys) + " is needed" + in_section(name));
  }
  if (group.need != KeyGroup::Need::exactly_one && group.need != KeyGroup::Need::at_most_one) return;
  if (given.empty() && group.need == KeyGroup::Need::exactly_one) {
    const std::string with = anchor ? " with '" + to_string(*anchor) + "'" : "";
    diagnostics.add({node.where, group.keys}, node.where,
                    "one of " + joined(group.keys) + " is needed" + in_section(name) + with);
  }
  if (given.size() > 1 && !count_as_one(given, group)) {
    diagnostics.add(node.find(given[1])->key_where,
                    "only one of " + joined(given) + " can be given" + in_section(name));
  }
}

/// "'a', 'b' or 'c'".
std::string quoted(const std::vector<Anchor>& anchors) {
  std::string text;
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    text += i == 0 ? "" : i + 1 < anchors.size() ? ", " : " or ";
    text += "'" + to_string(anchors[i]) + "'";
  }
  return text;
}

/// Was the choice not made, or badly, to which some keys of the section belong?
bool is_open(const std::string& choice, const InputNode& node, const KeyInfo& section) {
  const InputNode* made = node.find(choice);
  const auto key = std::ranges::find(section.children, choice, &KeyInfo::key);
  if (made == nullptr || key == section.children.end() || !key->schema->contains("enum")) return true;
  const auto& names = (*key->schema)["enum"];
  return std::ranges::none_of(names, [&](const auto& name) { return name == made->text; });
}

/// The owners of a key in all groups.
std::vector<Anchor> anchors_of(const std::string& key, const KeyInfo& section) {
  std::vector<Anchor> anchors;
  for (const KeyGroup& group : section.groups) {
    if (holds(group.keys, key)) anchors.insert(anchors.end(), group.only_with.begin(), group.only_with.end());
  }
  return anchors;
}

bool has_default(const std::string& key, const KeyInfo& section) {
  return std::any_of(section.children.begin(), section.children.end(),
                     [&](const KeyInfo& child) { return child.key == key && !child.fallback.empty(); });
}

/// Reports keys whose owners are not given. None where a choice is missing, which is already an error.
void check_strays(const InputNode& node, const std::string& name, const KeyInfo& section, Diagnostics& diagnostics) {
  for (const KeyGroup& group : section.groups) {
    if (group.only_with.empty() && group.need == KeyGroup::Need::exactly_one && given_keys(node, group).empty()) return;
  }
  for (const KeyInfo& key : section.children) {
    if (!is_given(node, key.key)) continue;
    const auto anchors = anchors_of(key.key, section);
    const auto is_there = [&](const Anchor& anchor) { return is_given(node, anchor); };
    if (anchors.empty() || std::any_of(anchors.begin(), anchors.end(), is_there)) continue;
    const bool is_chosen_by_default = !is_given(node, anchors[0].key) && has_default(anchors[0].key, section);
    if (!anchors[0].value.empty() && !is_chosen_by_default && is_open(anchors[0].key, node, section)) continue;
    const std::string message = "'" + key.key + "' can only be given with " + quoted(anchors) + in_section(name);
    const auto meant = synonym_of(key.key, usable(node, section));
    diagnostics.add(node.find(key.key)->key_where, meant ? message + " (did you mean '" + *meant + "'?)" : message);
  }
}

Json required_key(const std::string& key) {
  return {{"required", Json::array({key})}};
}

Json required_keys(const std::vector<std::string>& keys) {
  Json options = Json::array();
  for (const std::string& key : keys) options.push_back(required_key(key));
  return options;
}

/// The schema of maps that have what the group needs.
Json with_group(const KeyGroup& group) {
  if (group.need == KeyGroup::Need::exactly_one) {
    Json options = Json::array();
    for (const std::string& key : group.keys) {
      if (!count_as_one({key}, group)) options.push_back(required_key(key));
    }
    for (const auto& set : group.together) options.push_back({{"anyOf", required_keys(set)}});
    return {{"oneOf", options}};
  }
  if (group.need == KeyGroup::Need::at_least_one) return {{"anyOf", required_keys(group.keys)}};
  if (group.need == KeyGroup::Need::at_most_one) {
    Json pairs = Json::array();
    for (std::size_t i = 0; i < group.keys.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) pairs.push_back({{"required", {group.keys[j], group.keys[i]}}});
    }
    return {{"not", {{"anyOf", pairs}}}};
  }
  return {{"required", group.keys}};
}

/// The schema of maps in which the anchor is there.
Json with_anchor(const Anchor& anchor) {
  Json schema = required_key(anchor.key);
  if (!anchor.value.empty()) schema["properties"] = {{anchor.key, {{"const", anchor.value}}}};
  return schema;
}

/// Adds the group's conditions and dependencies to its section's schema.
void add_conditions(const KeyGroup& group, Json& schema) {
  if (group.only_with.empty()) {
    schema["allOf"].push_back(with_group(group));
    return;
  }
  Json anchors = Json::array();
  for (const Anchor& anchor : group.only_with) {
    anchors.push_back(with_anchor(anchor));
    if (group.need == KeyGroup::Need::any) continue;
    schema["allOf"].push_back({{"if", with_anchor(anchor)}, {"then", with_group(group)}});
  }
  for (const std::string& key : group.keys) {
    Json& beside = schema["dependencies"][key]["anyOf"];
    for (const Json& anchor : anchors) beside.push_back(anchor);
  }
}

Json default_value(const InputNode& node) {
  if (node.kind == InputNode::Kind::list) {
    Json items = Json::array();
    for (const InputNode& child : node.children) items.push_back(default_value(child));
    return items;
  }
  if (const auto number = parse_number(node.text)) {
    const auto whole = static_cast<long>(*number);
    return static_cast<double>(whole) == *number ? Json(whole) : Json(*number);
  }
  return node.text;
}

}  // namespace

bool KeyInfo::has_type(const char* json_type) const {
  return schema != nullptr && schema->contains("type") && schema->at("type") == json_type;
}

std::string to_string(const Anchor& anchor) {
  return anchor.value.empty() ? anchor.key : anchor.key + ": " + anchor.value;
}

bool is_part_of_formula(std::string_view text) {
  return std::count(text.begin(), text.end(), '(') != std::count(text.begin(), text.end(), ')');
}

namespace {

bool is_plain(const InputNode& node) {
  return node.kind == InputNode::Kind::scalar && node.style == InputNode::Style::plain;
}

/// Blanks between the ',' behind an entry of a list in [ ] and the next; none if they are on several lines or quoted.
std::optional<int> blanks_between(const InputNode& before, const InputNode& entry) {
  if (!is_plain(before) || !is_plain(entry) || before.where.line != entry.where.line) return std::nullopt;
  return entry.where.column - before.where.column - static_cast<int>(before.text.size()) - 1;
}

/// Whether the two read as one number with a decimal comma: digits, ',' and digits without a blank.
bool has_decimal_comma(const InputNode& before, const InputNode& entry) {
  return blanks_between(before, entry) == 0 && !before.text.empty() && starts_with_digit(entry.text) &&
         starts_with_digit(before.text.substr(before.text.size() - 1));
}

bool is_whole_number(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// `friction:` and nothing behind it: the default is probably not what was meant.
void warn_of_empty(const InputNode& empty, const std::string& section, const KeyInfo& key, Diagnostics& diagnostics) {
  const std::string fallback = key.fallback.empty() ? "" : ", with the default " + key.fallback;
  diagnostics.warn(empty.key_where,
                   "key '" + key.key + "'" + in_section(section) + " has no value; it counts as not given" + fallback);
}

}  // namespace

void warn_of_decimal_commas(const InputNode& node, Diagnostics& diagnostics) {
  for (const InputNode& child : node.children) warn_of_decimal_commas(child, diagnostics);
  if (node.kind != InputNode::Kind::list) return;
  const InputNode* number = nullptr;  // whose decimals are the next entry
  bool has_blank = false;
  for (std::size_t i = 1; i < node.children.size(); ++i) {
    const InputNode &before = node.children[i - 1], &entry = node.children[i];
    has_blank = has_blank || blanks_between(before, entry).value_or(0) > 0;
    // A decimal part of zeros alone would change nothing.
    const bool is_number = has_decimal_comma(before, entry) && is_whole_number(before.text) &&
                           entry.text.find_first_not_of('0') != std::string::npos;
    if (is_number && number == nullptr) number = &before;
  }
  if (number == nullptr || !has_blank) return;
  const InputNode& decimals = *(number + 1);
  diagnostics.warn(number->where, "'" + excerpt(number->text) + "," + excerpt(decimals.text) +
                                      "' is read as two entries of the list; if it is one number, write " +
                                      excerpt(number->text) + "." + excerpt(decimals.text) +
                                      "; if it is two, put a space after the ','");
}

std::string why_split(const InputNode& list) {
  for (std::size_t i = 0; i < list.children.size(); ++i) {
    const InputNode& entry = list.children[i];
    if (entry.kind != InputNode::Kind::scalar || entry.style != InputNode::Style::plain) continue;
    if (is_part_of_formula(entry.text)) {
      return " (a ',' splits '" + excerpt(entry.text) +
             "'; inside [ ], put a formula in quotes, such as \"min(t, 1)\")";
    }
    if (i == 0) continue;
    const InputNode& before = list.children[i - 1];
    if (has_decimal_comma(before, entry) && before.text.find_first_of(".eE") == std::string::npos) {
      return " (a decimal point is written '.': " + excerpt(before.text) + "." + excerpt(entry.text) + ")";
    }
  }
  return "";
}

bool refuse(const InputNode& node, const std::string& name, const std::string& wanted, Diagnostics& diagnostics) {
  diagnostics.add(node.place(), "'" + name + "' must be " + wanted + ", not " + description(node));
  return false;
}

bool refuse_short(const InputNode& list, const std::string& name, std::size_t fewest, Diagnostics& diagnostics) {
  if (fewest == 1) return refuse(list, name, "a list with entries", diagnostics);
  diagnostics.add(list.place(), "'" + name + "' must be a list of at least " + std::to_string(fewest) +
                                    " entries, not of " + std::to_string(list.children.size()));
  return false;
}

bool check_keys(const InputNode& node, const std::string& name, const KeyInfo& section, Diagnostics& diagnostics) {
  if (node.kind != InputNode::Kind::map) {
    if (node.kind == InputNode::Kind::scalar && node.text.find(':') != std::string::npos) {
      diagnostics.add(node.where, "keys and values are expected here; the ':' after a key must be followed by a space");
    } else if (name.empty()) {
      diagnostics.add(node.where,
                      "the input must be a map of keys such as 'mesh:' and 'time:', not " + description(node));
    } else {
      const auto is_required = [](const KeyInfo& key) { return key.need == KeyInfo::Need::required; };
      const auto first = std::ranges::find_if(section.children, is_required);
      const KeyInfo& such_as = first == section.children.end() ? section.children.front() : *first;
      refuse(node, name, "a map of keys such as '" + such_as.key + ":'", diagnostics);
    }
    return false;
  }
  if (name.empty()) diagnostics.look_up_in(section);
  const auto names = names_of(section.children);
  for (const InputNode& child : node.children) {
    if (std::find(names.begin(), names.end(), child.key) == names.end()) {
      report_unknown_key(child, name, node, section, diagnostics);
    }
  }
  for (const KeyInfo& key : section.children) {
    if (is_given(node, key.key)) continue;
    const InputNode* empty = node.find(key.key);
    if (key.need != KeyInfo::Need::required) {
      if (empty != nullptr && empty->text.empty()) warn_of_empty(*empty, name, key, diagnostics);
    } else if (empty != nullptr) {
      diagnostics.add(empty->key_where, "key '" + key.key + "'" + in_section(name) + " has no value");
    } else {
      diagnostics.add({node.where, {key.key}}, node.where, "missing key '" + key.key + "'" + in_section(name));
    }
  }
  for (const KeyGroup& group : section.groups) check_group(node, name, group, diagnostics);
  check_strays(node, name, section, diagnostics);
  return true;
}

JsonSchema list_schema(const JsonSchema& entry, std::size_t fewest, std::optional<std::size_t> most) {
  Json schema{{"type", "array"}, {"items", *entry}, {"minItems", fewest}};
  if (most) schema["maxItems"] = *most;
  return std::make_shared<Json>(std::move(schema));
}

JsonSchema either_schema(const JsonSchema& one, const JsonSchema& other) {
  return std::make_shared<Json>(Json{{"anyOf", Json::array({*one, *other})}});
}

JsonSchema object_schema(const std::vector<KeyInfo>& keys, const std::vector<KeyGroup>& groups) {
  Json properties = Json::object();
  Json required = Json::array();
  for (const KeyInfo& key : keys) {
    Json value = *key.schema;
    value["description"] = key.description;
    if (!key.fallback.empty()) {
      Diagnostics none;
      value["default"] = default_value(parse_yaml(key.fallback, "default", none));
    }
    properties[key.key] = value;
    if (key.need == KeyInfo::Need::required) required.push_back(key.key);
  }
  Json schema{{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  for (const KeyGroup& group : groups) add_conditions(group, schema);
  return std::make_shared<Json>(std::move(schema));
}

}  // namespace pliant
