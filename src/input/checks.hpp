/// Contradictions between keys that are valid by themselves.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Reports contradictions in a configuration that was read from `root`; values that could not be read cause none.
void check_combinations(const Config& config, const InputNode& root, Diagnostics& diagnostics);

/// Without inertia, every direction needs a constraint against moving as a whole.
void check_held(const Config& config, const InputNode& root, Diagnostics& diagnostics);

}  // namespace pliant
