/// What must hold between keys, beyond what the table says of each.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Adds the contradictions in a configuration that was read from `root`; values that could not be read raise none.
void check_combinations(const Config& config, const InputNode& root, Diagnostics& diagnostics);

}  // namespace pliant
