/// Keys that other programs have, and what stands for them here.
#pragma once

#include <string_view>

namespace pliant {

/// The key that a word of other programs means in a section, such as "obstacles[0]" or, for the top level, ""; else
/// empty.
std::string_view key_for(std::string_view word, std::string_view section);

/// In words what stands for a key that no key of the section replaces as it is; else empty.
std::string_view instead_of(std::string_view word, std::string_view section);

}  // namespace pliant
