/// What the keys of rods cannot say one by one.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

void check_rods(const Config& config, Diagnostics& diagnostics);

}  // namespace pliant
