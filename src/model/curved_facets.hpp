/// Curved facets that are too coarse for the gap between bodies.
#pragma once

#include "model/touching_surfaces.hpp"

namespace pliant {

/// Whether the triangles that have the mean of curved facets overlap at rest, or come to less than half of the distance
/// of those between the nodes: vertices of facets of size h and radius R are h^2/(24 R) outside of the nodes.
/// Collective.
bool is_too_curved(const NodeLayout& layout, const TouchingSurfaces& touching, std::size_t num_bodies);

}  // namespace pliant
