/// The parts of the bodies from which columns of the history take fields.
#pragma once

#include "fem/selection.hpp"
#include "input/config.hpp"
#include "model/selections.hpp"

#include <array>
#include <span>
#include <vector>

namespace pliant {

/// A volume or a surface, as this rank's part of it; each cell and facet belongs to one rank's. Or shells or rods, for
/// fields of those.
struct FieldRegion {
  std::vector<PetscInt> cells;  ///< owned; none of a surface
  int nodes_per_facet = 3;
  std::vector<PetscInt> facets;                       ///< local nodes; none of a volume
  std::vector<std::array<PetscInt, 2>> facets_cells;  ///< local cells on both sides of each facet; -1: none

  std::vector<std::size_t> parts;  ///< numbers of shells or rods, if the field is of those

  std::span<const PetscInt> nodes_of_facet(std::size_t facet) const {
    const auto width = static_cast<std::size_t>(nodes_per_facet);
    return std::span(facets).subspan(width * facet, width);
  }
};

/// One for each entry of `output.history`, empty for the value at a probe. Cells that stand for bodies without a mesh
/// are left out; free shells are their triangles. Reports names that the mesh does not have to `selections`.
/// Collective.
std::vector<FieldRegion> find_field_regions(const Config& config, const NodeLayout& layout,
                                            const std::vector<int>& body_of_cell, Selections& selections);

}  // namespace pliant
