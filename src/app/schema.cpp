#include "app/schema.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <optional>

namespace pliant {
namespace {

std::vector<std::string> names_of(const std::vector<KeyInfo>& keys) {
  std::vector<std::string> names;
  for (const KeyInfo& key : keys) names.push_back(key.key);
  return names;
}

std::string in_section(const std::string& name) {
  return name.empty() ? "" : " in " + name;
}

std::string unknown_key(const std::string& key, const std::string& section_name, const KeyInfo& section) {
  if (is_planned(key)) return "'" + key + "' is not supported by this version of Pliant";
  const std::string message = "unknown key '" + excerpt(key) + "'" + in_section(section_name);
  const auto names = names_of(section.children);
  if (const std::size_t colon = key.find(':'); colon != std::string::npos) {
    return message + " (a blank must follow the ':' after a key)";
  }
  const std::string guess = did_you_mean(key, names);
  if (!guess.empty()) return message + guess;
  for (const KeyInfo& child : section.children) {
    const auto inner = names_of(child.children);
    if (std::find(inner.begin(), inner.end(), key) != inner.end()) {
      return message + " (it belongs in " + child.key + ")";
    }
  }
  return message + "; the keys are " + joined(names);
}

bool is_given(const InputNode& node, const std::string& key) {
  const InputNode* value = node.find(key);
  return value != nullptr && value->kind != InputNode::Kind::null;
}

std::vector<std::string> given_keys(const InputNode& node, const OneOf& group) {
  std::vector<std::string> given;
  std::copy_if(group.keys.begin(), group.keys.end(), std::back_inserter(given),
               [&](const std::string& key) { return is_given(node, key); });
  return given;
}

/// The key there that the group's keys stand beside.
std::optional<std::string> anchor_of(const InputNode& node, const OneOf& group) {
  const auto found = std::find_if(group.beside.begin(), group.beside.end(),
                                  [&](const std::string& key) { return is_given(node, key); });
  return found == group.beside.end() ? std::nullopt : std::optional(*found);
}

void check_alternatives(const InputNode& node, const std::string& name, const OneOf& group, Problems& problems) {
  const auto given = given_keys(node, group);
  const auto anchor = anchor_of(node, group);
  if (!group.beside.empty() && !anchor) return;
  const std::string beside = anchor ? " beside '" + *anchor + "'" : "";
  if (given.empty() && group.need == OneOf::Need::exactly_one) {
    const std::string choice = group.keys.size() == 1 ? "'" + group.keys.front() + "'" : "one of " + joined(group.keys);
    problems.add(node.where, choice + " is needed" + in_section(name) + beside);
  }
  if (given.size() > 1 && group.need != OneOf::Need::any) {
    problems.add(node.find(given[1])->key_where, "only one of " + joined(given) + " can be given" + in_section(name));
  }
}

/// "'a' or 'b'".
std::string quoted(const std::vector<std::string>& keys) {
  std::string text;
  for (const std::string& key : keys) text += (text.empty() ? "'" : " or '") + key + "'";
  return text;
}

/// Keys that stand only beside another key which is not there. None where a choice is missing, which is told already.
void check_strays(const InputNode& node, const std::string& name, const KeyInfo& section, Problems& problems) {
  for (const OneOf& group : section.alternatives) {
    if (group.beside.empty() && group.need == OneOf::Need::exactly_one && given_keys(node, group).empty()) return;
  }
  for (const OneOf& group : section.alternatives) {
    if (group.beside.empty() || anchor_of(node, group)) continue;
    for (const std::string& key : group.keys) {
      if (!is_given(node, key)) continue;
      problems.add(node.find(key)->key_where,
                   "'" + key + "' goes only beside " + quoted(group.beside) + in_section(name));
    }
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

Json exclusion(const OneOf& group) {
  Json options = required_keys(group.keys);
  if (group.need == OneOf::Need::exactly_one) return {{"oneOf", options}};
  options.push_back({{"not", {{"anyOf", options}}}});
  return {{"oneOf", options}};
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

bool refuse(const InputNode& node, const std::string& name, const std::string& wanted, Problems& problems) {
  problems.add(node.place(), "'" + name + "' must be " + wanted + ", not " + description(node));
  return false;
}

bool check_keys(const InputNode& node, const std::string& name, const KeyInfo& section, Problems& problems) {
  if (node.kind != InputNode::Kind::map) {
    if (node.kind == InputNode::Kind::scalar && node.text.find(':') != std::string::npos) {
      problems.add(node.where, "keys and values are needed here; a blank must follow the ':' after a key");
    } else if (name.empty()) {
      problems.add(node.where, "the input must be a map of keys such as 'mesh:' and 'time:', not " + description(node));
    } else {
      refuse(node, name, "a map of keys", problems);
    }
    return false;
  }
  const auto names = names_of(section.children);
  for (const InputNode& child : node.children) {
    if (std::find(names.begin(), names.end(), child.key) == names.end()) {
      problems.add(child.key_where, unknown_key(child.key, name, section));
    }
  }
  for (const KeyInfo& key : section.children) {
    if (key.need != KeyInfo::Need::required || is_given(node, key.key)) continue;
    const InputNode* empty = node.find(key.key);
    problems.add(empty != nullptr ? empty->key_where : node.where,
                 empty != nullptr ? "key '" + key.key + "'" + in_section(name) + " has no value"
                                  : "missing key '" + key.key + "'" + in_section(name));
  }
  for (const OneOf& group : section.alternatives) check_alternatives(node, name, group, problems);
  check_strays(node, name, section, problems);
  return true;
}

Json object_schema(const std::vector<KeyInfo>& keys, const std::vector<OneOf>& alternatives) {
  Json properties = Json::object();
  Json required = Json::array();
  for (const KeyInfo& key : keys) {
    Json value = key.schema;
    value["description"] = key.description;
    if (!key.fallback.empty()) {
      Problems none;
      value["default"] = default_value(parse_yaml(key.fallback, "default", none));
    }
    properties[key.key] = value;
    if (key.need == KeyInfo::Need::required) required.push_back(key.key);
  }
  Json schema{{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  Json exclusions = Json::array();
  for (const OneOf& group : alternatives) {
    if (group.beside.empty()) {
      exclusions.push_back(exclusion(group));
    } else {
      for (const std::string& anchor : group.beside) {
        if (group.need != OneOf::Need::any) schema["dependencies"][anchor]["allOf"].push_back(exclusion(group));
      }
      for (const std::string& key : group.keys) schema["dependencies"][key] = {{"anyOf", required_keys(group.beside)}};
    }
  }
  if (!exclusions.empty()) schema["allOf"] = exclusions;
  return schema;
}

}  // namespace pliant
