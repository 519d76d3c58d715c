#include "model/field_regions.hpp"

#include "fem/cell_integration.hpp"
#include "petsc/collective.hpp"

#include <fmt/format.h>

namespace pliant {
namespace {

FieldRegion volume_region(const NodeLayout& layout, const std::vector<char>& left_out, const Selection& part,
                          Selections& selections) {
  FieldRegion region;
  const std::vector<char> is_in = selections.cells(part);
  for (PetscInt cell = 0; cell < layout.num_owned_cells; ++cell) {
    if (is_in[cell] != 0 && (left_out.empty() || left_out[cell] == 0)) region.cells.push_back(cell);
  }
  if (sum(layout.comm, static_cast<PetscInt64>(region.cells.size())) == 0) {
    selections.report(part.where, fmt::format("{} contains no tetrahedron of a body with a mesh", describe(part)));
  }
  return region;
}

FieldRegion surface_region(const NodeLayout& layout, const Selection& part, Selections& selections) {
  FieldRegion region;
  const FacetList facets = selections.facets(part);
  region.nodes_per_facet = facets.nodes_per_facet;
  for (PetscInt facet = 0; facet < facets.size(); ++facet) {
    const auto nodes = facets.nodes_of(facet);
    if (facets.is_owned[facet] != 0) region.facets.insert(region.facets.end(), nodes.begin(), nodes.end());
  }
  region.facets_cells = cells_of_facets(layout, region.facets, region.nodes_per_facet);
  return region;
}

}  // namespace

std::vector<FieldRegion> find_field_regions(const Config& config, const NodeLayout& layout,
                                            const std::vector<char>& left_out, Selections& selections) {
  std::vector<FieldRegion> regions;
  for (const FieldColumnConfig& column : config.output.history) {
    Selection part;
    part.where = column.where;
    if (column.in) {
      const auto found = selections.volume_or_surface(*column.in);
      if (!found) {
        regions.emplace_back();
        continue;
      }
      part = *found;
    }
    regions.push_back(part.kind == Selection::Kind::surface ? surface_region(layout, part, selections)
                                                            : volume_region(layout, left_out, part, selections));
  }
  return regions;
}

}  // namespace pliant
