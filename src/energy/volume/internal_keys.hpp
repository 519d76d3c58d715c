/// What the internal variables of terms are called, whichever rank has them.
#pragma once

#include "energy/term.hpp"
#include "fem/entry_keys.hpp"
#include "fem/layout.hpp"
#include "petsc/global_order.hpp"

#include <span>
#include <vector>

namespace pliant {

/// Of each six of this rank's internal variables, in their order (IncrementalPotential::make_internal), those of ghost
/// cells included: the number of the cell, then the term, what of it, and the point. Points are told by their
/// barycentric coordinates to the vertices in the order of their numbers, for a rank may list a cell's vertices in any
/// order. Not collective.
std::vector<EntryKey> internal_keys(const NodeLayout& layout, std::span<const EnergyTerm* const> terms);

}  // namespace pliant
