/// The reference of the input, from the table of its keys.
#pragma once

#include <string>

namespace pliant {

/// The reference of the input in Markdown: docs/input.md.
std::string input_reference();

}  // namespace pliant
