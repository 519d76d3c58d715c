/// What cannot be combined in `output`, and names that are given twice.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Reports fields and columns that are given twice, and those that the input has no values for. `root`: of the input.
void check_output(const Config& config, const InputNode& root, Diagnostics& diagnostics);

/// Reports entries of a list that must differ, as "the `what` 'value' is given twice".
void check_unique(const std::vector<std::string>& values, const std::vector<Location>& places, const std::string& what,
                  Diagnostics& diagnostics);

}  // namespace pliant
