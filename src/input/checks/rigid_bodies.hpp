/// Checks of rigid bodies and joints that need no mesh.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Moments of inertia that no body has, and names that are given twice.
void check_rigid_bodies(const Config& config, Diagnostics& diagnostics);

}  // namespace pliant
