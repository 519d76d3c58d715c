/// The walls of chambers among the facets of a mesh.
#pragma once

#include "fem/selection.hpp"

#include <span>

namespace pliant {

/// Gives the facets of free shells in a surface the orientation that belongs to the chamber of this surface
/// (mesh/chamber_walls.hpp): a shell between two chambers has another one in the walls of each. `is_shell`: per local
/// cell; empty if none is. Collective.
void orient_shells_in_walls(const NodeLayout& layout, std::span<const char> is_shell, FacetList& facets);

}  // namespace pliant
