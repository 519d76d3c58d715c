/// The file from which `pliant fit` starts: its keys, and reading it.
#pragma once

#include "input/schema.hpp"
#include "study/fit_config.hpp"

#include <string>
#include <vector>

namespace pliant {

/// The table of the keys of a fit file.
const std::vector<KeyInfo>& fit_keys();

/// JSON Schema (draft 7) of a fit file.
std::string fit_schema();

/// The reference of the keys in Markdown: docs/fit-file.md.
std::string fit_reference();

/// Reads a fit from its text; `file` is its name for messages. Throws InputError with every error, each at its line
/// and column. Not collective.
FitConfig read_fit(const std::string& text, const std::string& file);

}  // namespace pliant
