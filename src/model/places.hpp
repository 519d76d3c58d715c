/// Warnings about places that are probably not in metres.
#pragma once

#include "fem/layout.hpp"
#include "input/config.hpp"

#include <vector>

namespace pliant {

/// Warns of a mesh, of surfaces of rigid bodies and of places of the input that are probably in millimetres.
/// `config`: completed by with_rigid_bodies. Collective over the ranks of `layout`.
std::vector<Diagnostic> warnings_about_places(const Config& config, const NodeLayout& layout,
                                              const std::vector<int>& body_of_cell);

}  // namespace pliant
