/// The table of the input's keys, and what follows from it.
#pragma once

#include "input/schema.hpp"
#include "input/sections/time.hpp"

namespace pliant {

/// The whole table; sections hold their keys as children.
const std::vector<KeyInfo>& input_keys();

/// Reads every key that is there and puts the table's defaults for the others.
Config read_config(const InputNode& root, Diagnostics& diagnostics);

/// The tree that read_config reads as this configuration.
InputNode write_config(const Config& config);

/// JSON schema of the whole input.
JsonSchema input_schema();

}  // namespace pliant
