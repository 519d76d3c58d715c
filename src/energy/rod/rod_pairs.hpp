/// Which segments of rods are neighbours: pairs that the mesh fixes.
#pragma once

#include "energy/coupling.hpp"
#include "fem/layout.hpp"

#include <cstddef>
#include <span>

namespace pliant {

/// The neighbours of which one has a node of this rank. `patches`: the segments of this rank's cells, whose keys are
/// their numbers; `vertex_after`: of each segment, -1 where no vertex joins it to the next. Collective.
FixedPairs pairs_of_neighbours(const NodeLayout& layout, const Patches& patches,
                               std::span<const std::ptrdiff_t> vertex_after);

}  // namespace pliant
