/// What is said of a key that its section does not have.
#pragma once

#include "input/schema.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

std::vector<std::string> names_of(const std::vector<KeyInfo>& keys);

/// " in NAME", or nothing for the whole input.
std::string in_section(const std::string& name);

bool is_given(const InputNode& node, const std::string& key);
bool is_given(const InputNode& node, const Anchor& anchor);

/// Digits, such as the end of a number after a decimal comma.
bool starts_with_digit(std::string_view text);

/// The keys of the section that are useful with what is chosen in the node.
std::vector<KeyInfo> usable(const InputNode& node, const KeyInfo& section);

/// The key of which this is another name, in other programs or with another choice.
std::optional<std::string> synonym_of(const std::string& key, const std::vector<KeyInfo>& keys);

/// Reports a child of the node whose key is unknown, with the section to which the key belongs or the key probably
/// meant.
void report_unknown_key(const InputNode& child, const std::string& section_name, const InputNode& node,
                        const KeyInfo& section, Diagnostics& diagnostics);

}  // namespace pliant
