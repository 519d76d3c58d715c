/// The pieces of a mesh that hang together.
#pragma once

#include "fem/layout.hpp"

#include <functional>
#include <vector>

namespace pliant {

/// The owned nodes of each piece of the mesh whose cells share nodes and of which no owned node `is_held` on any rank;
/// in an order that all ranks share, empty on ranks that have no part of the piece. Collective.
std::vector<std::vector<PetscInt>> connected_bodies(const NodeLayout& layout,
                                                    const std::function<bool(PetscInt node)>& is_held);

}  // namespace pliant
