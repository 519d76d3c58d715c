/// What cannot be combined in `time`.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Reports contradictions in `time`. `root`: of the input.
void check_time(const TimeConfig& time, const InputNode& root, Diagnostics& diagnostics);

/// Reports what cannot be combined with a path of equilibria.
void check_path(const Config& config, Diagnostics& diagnostics);

}  // namespace pliant
