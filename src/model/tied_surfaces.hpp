/// The input's ties of surfaces (`tied_to`) on the mesh.
#pragma once

#include "energy/constraint/tied_surfaces.hpp"
#include "model/selections.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The tie of the constraint `config.constraints[index]`; what is wrong stands in `selections`. Collective.
std::optional<SurfaceTie> make_tie(const Config& config, std::size_t index, const NodeLayout& layout,
                                   Selections& selections);

/// The nodes of this rank that the tie makes dependent. Not collective.
std::vector<PetscInt> owned_nodes(const NodeLayout& layout, const SurfaceTie& tie);

/// How many nodes are tied and how far they are; how many stay free.
Diagnostic note_of(const Config& config, const SurfaceTie& tie);

/// The two surfaces of each tie.
std::vector<std::array<Selection, 2>> tied_surfaces(const Config& config);

}  // namespace pliant
