/// Warnings about places that are probably not in metres.
#pragma once

#include "fem/layout.hpp"
#include "input/config.hpp"

#include <span>
#include <vector>

namespace pliant {

/// Warns of a mesh, of surfaces of rigid bodies and of places of the input that are probably in millimetres.
/// `config`: completed by with_rigid_bodies; `shear_moduli`: of its bodies [Pa], 0 of those without. Collective over
/// the ranks of `layout`.
std::vector<Diagnostic> warnings_about_places(const Config& config, const NodeLayout& layout,
                                              const std::vector<int>& body_of_cell,
                                              std::span<const double> shear_moduli);

}  // namespace pliant
