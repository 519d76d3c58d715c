/// YAML text to a tree of texts with their places.
#pragma once

#include "input/tree.hpp"

#include <string>
#include <string_view>

namespace pliant {

/// The error of parse_yaml for text after the first document.
constexpr std::string_view several_documents =
    "the input ends before this line; check that the line is indented like its neighbours (a file holds one document)";

/// Reads YAML text (UTF-8). In addition to what yaml-cpp rejects, it rejects: keys given twice, several documents,
/// quotes that are not closed, anything that is not text, and more depth or values than an input can need (alias
/// bombs). Errors that leave a usable tree are added to `diagnostics`; others throw InputError.
InputNode parse_yaml(const std::string& text, const std::string& file, Diagnostics& diagnostics);

}  // namespace pliant
