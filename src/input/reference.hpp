/// The reference of the input, from the table of its keys.
#pragma once

#include "input/schema.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Tables of the keys in Markdown: those at the top, then a section for each that has keys of its own.
std::string key_reference(const std::vector<KeyInfo>& keys);

/// The reference of the input in Markdown: docs/input.md.
std::string input_reference();

}  // namespace pliant
