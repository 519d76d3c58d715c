/// What an input may mean, but seldom does: nothing is wrong with it, and the user is warned.
#pragma once

#include "app/config.hpp"
#include "app/selections.hpp"
#include "energy/prescribed.hpp"

#include <string>
#include <vector>

namespace pliant {

/// What the input alone tells, each with its place, in plain words.
std::vector<std::string> doubts_about(const Config& config);

/// Loads on parts of which every node is given its displacement: they move nothing. `selections` must be without
/// mistakes. Collective over the ranks of `layout`.
std::vector<std::string> doubts_about_loads(const Config& config, const NodeLayout& layout, Selections& selections,
                                            const PrescribedDisplacement& prescribed);

}  // namespace pliant
