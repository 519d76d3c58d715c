/// Plane surfaces.
#pragma once

#include "base/vector3.hpp"
#include "fem/selection.hpp"

#include <optional>

namespace pliant {

/// The outward unit normal that facets of the mesh's surface share; nothing if they do not lie in one plane, to 1e-6 of
/// their extent. Components below 1e-9 are rounding and taken as zero. Collective.
std::optional<Vector3<double>> common_normal(const NodeLayout& layout, const FacetList& facets);

}  // namespace pliant
