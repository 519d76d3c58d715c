/// Keys that identify the internal variables of terms, whichever rank holds them.
#pragma once

#include "energy/term.hpp"
#include "fem/entry_keys.hpp"
#include "fem/layout.hpp"
#include "petsc/global_order.hpp"

#include <span>
#include <vector>

namespace pliant {

/// How many internal variables share a key: num_symmetric, or 1 if a term has single numbers.
int internal_components(std::span<const EnergyTerm* const> terms);

/// A key for each `internal_components` of this rank's internal variables, in their order
/// (IncrementalPotential::make_internal), those of ghost cells included: the number of the cell, then the term, the
/// kind of variable, the point, and the component where each has a key of its own. Points are identified by their
/// barycentric coordinates, with the vertices in ascending order of their numbers, because ranks may list a cell's
/// vertices in different orders. Not collective.
std::vector<EntryKey> internal_keys(const NodeLayout& layout, std::span<const EnergyTerm* const> terms);

}  // namespace pliant
