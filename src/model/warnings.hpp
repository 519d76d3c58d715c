/// What an input may mean, but seldom does: nothing is wrong with it, and the user is warned of it.
#pragma once

#include "energy/constraint/prescribed.hpp"
#include "input/config.hpp"
#include "mesh/report.hpp"
#include "model/selections.hpp"

#include <vector>

namespace pliant {

/// What shows in the input alone; with the warnings about its text.
std::vector<Diagnostic> warnings_about(const Config& config);

/// Does the input alone leave the bodies at rest? Terms that others add may move them.
bool nothing_moves(const Config& config);

/// Do loads push the bodies that no constraint holds, and nothing else stops them, nor are they thrown?
bool may_fall(const Config& config);

/// Notes of what the input gives and its kind of analysis does not use.
std::vector<Diagnostic> notes_of_idle_keys(const Config& config);

/// A mesh in other units than metres.
std::vector<Diagnostic> warnings_about_mesh(const Config& config, const MeshReport& mesh);

/// Constraints that a motion does not start from. Collective over the ranks of `layout`, as the next.
std::vector<Diagnostic> warnings_about_start(const Config& config, const NodeLayout& layout, Selections& selections);

/// Loads on parts of which every node is given its displacement: they move nothing. `selections` must be without
/// errors.
std::vector<Diagnostic> warnings_about_loads(const Config& config, const NodeLayout& layout, Selections& selections,
                                             const PrescribedDisplacement& prescribed);

}  // namespace pliant
