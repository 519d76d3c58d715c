/// What nodes and pressures are called, whichever rank has them; and what the mesh is.
#pragma once

#include "fem/layout.hpp"
#include "fem/pressure_layout.hpp"
#include "petsc/global_order.hpp"

#include <cstdint>
#include <vector>

namespace pliant {

/// Keys of the owned nodes: the numbers of the two vertices between which a node lies, or twice that of its vertex. Not
/// collective.
std::vector<EntryKey> node_keys(const NodeLayout& layout);

/// Keys of the owned pressures: the number of the vertex, and the body. Not collective.
std::vector<EntryKey> pressure_keys(const NodeLayout& layout, const PressureLayout& pressures);

/// A number that another mesh, or the same one with a node elsewhere, does not have (but by a chance of 1 in 2^64); the
/// same on any number of ranks. Collective.
std::uint64_t fingerprint(const NodeLayout& layout);

}  // namespace pliant
