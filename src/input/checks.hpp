/// Contradictions between keys that are valid by themselves.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Reports contradictions in a configuration that was read from `root`; values that could not be read cause none.
void check_combinations(const Config& config, const InputNode& root, Diagnostics& diagnostics);

/// Whether something besides constraints and contact holds a body to the ground: springs, tendons, joints or rods.
bool is_held_by_springs_or_joints(const Config& config);

/// Without inertia, every direction needs a constraint against moving as a whole.
void check_held(const Config& config, const InputNode& root, Diagnostics& diagnostics);

}  // namespace pliant
