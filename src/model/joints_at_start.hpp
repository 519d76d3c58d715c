/// What joints make of the displacements and velocities at the start.
#pragma once

#include "input/config.hpp"
#include "model/mechanisms.hpp"

#include <span>
#include <vector>

namespace pliant {

/// A warning where joints forbid displacements that the input gives, and one for velocities: the run starts from
/// others, which are nearest. None in a static analysis. `config`: with all rigid bodies. Throws InputError where the
/// motion of a joint does not begin where the bodies are. Collective.
std::vector<Diagnostic> warnings_about_joints_at_start(const Config& config, const NodeLayout& layout,
                                                       const std::vector<int>& body_of_cell,
                                                       std::span<const ModelJoint> joints);

}  // namespace pliant
