/// Keys that identify nodes and pressures whichever rank holds them, and a fingerprint of the mesh.
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

/// A fingerprint: another mesh, or this one with a moved node, has another number (except with probability 2^-64); the
/// same on any number of ranks. Collective.
std::uint64_t fingerprint(const NodeLayout& layout);

}  // namespace pliant
