/// Contradictions between the keys of `tendons[]`.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

void check_tendons(const Config& config, Diagnostics& diagnostics);

}  // namespace pliant
