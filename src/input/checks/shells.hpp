/// What the keys of shells cannot say one by one.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

void check_shells(const Config& config, Diagnostics& diagnostics);

}  // namespace pliant
