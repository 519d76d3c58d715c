/// What must hold between keys, beyond what the table says of each.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Puts the defaults that follow from other keys and resolves the mesh's file against the directory of `config.file`.
void complete_defaults(Config& config, const InputNode& root);

/// Adds the contradictions in a configuration that was read from `root`; values that could not be read raise none.
void check_combinations(const Config& config, const InputNode& root, Diagnostics& diagnostics);

}  // namespace pliant
