#include "model/field_regions.hpp"

#include "fem/cell_integration.hpp"
#include "input/output_fields.hpp"
#include "model/rigid_bodies.hpp"
#include "model/shells.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

namespace pliant {
namespace {

/// `hint`: what follows if there is nothing.
FieldRegion volume_region(const NodeLayout& layout, const std::vector<char>& left_out, const Selection& part,
                          const std::string& hint, Selections& selections) {
  FieldRegion region;
  const std::vector<char> is_in = selections.cells(part);
  for (PetscInt cell = 0; cell < layout.num_owned_cells; ++cell) {
    if (is_in[cell] != 0 && left_out[cell] == 0) region.cells.push_back(cell);
  }
  if (sum(layout.comm, static_cast<PetscInt64>(region.cells.size())) == 0) {
    selections.report(part.where,
                      fmt::format("{} contains no tetrahedron of a body with a mesh{}", describe(part), hint));
  }
  return region;
}

void append_surface(const Selection& part, Selections& selections, FieldRegion& region) {
  const FacetList facets = selections.facets(part);
  region.nodes_per_facet = facets.nodes_per_facet;
  for (PetscInt facet = 0; facet < facets.size(); ++facet) {
    const auto nodes = facets.nodes_of(facet);
    if (facets.is_owned[facet] != 0) region.facets.insert(region.facets.end(), nodes.begin(), nodes.end());
  }
}

FieldRegion surface_region(const NodeLayout& layout, const Selection& part, Selections& selections) {
  FieldRegion region;
  append_surface(part, selections, region);
  region.facets_cells = cells_of_facets(layout, region.facets, region.nodes_per_facet);
  return region;
}

/// The triangles of free shells: of one, or of all.
FieldRegion free_shells_region(const Config& config, const NodeLayout& layout, const std::string* name,
                               Selections& selections) {
  FieldRegion region;
  for (const ShellConfig& shell : config.shells) {
    if (shell.is_free && (name == nullptr || shell.name == *name)) append_surface(shell.part, selections, region);
  }
  region.facets_cells = cells_of_facets(layout, region.facets, region.nodes_per_facet);
  return region;
}

/// Numbers of the entries with the name, or of all.
template <class Entry>
std::vector<std::size_t> numbers_of(const std::vector<Entry>& entries, const std::optional<Located<std::string>>& in) {
  std::vector<std::size_t> numbers;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    if (!in || entries[k].name == in->value) numbers.push_back(k);
  }
  return numbers;
}

bool is_free_shell(const Config& config, const std::string& name) {
  const auto shell = std::ranges::find(config.shells, name, &ShellConfig::name);
  return shell != config.shells.end() && shell->is_free;
}

/// Is any body more than what stands for it?
bool has_tetrahedra(const Config& config) {
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    if (!stands_for_body(config, static_cast<int>(b))) return true;
  }
  return false;
}

/// Nothing where a name is not of the mesh, which has been reported.
FieldRegion region_of(const Config& config, const NodeLayout& layout, const std::vector<char>& left_out,
                      const FieldColumnConfig& column, Selections& selections) {
  Selection part;
  part.where = column.where;
  if (column.in) {
    if (is_free_shell(config, column.in->value)) {
      return free_shells_region(config, layout, &column.in->value, selections);
    }
    const auto found = selections.volume_or_surface(*column.in);
    if (!found) return {};
    part = *found;
  } else if (has_free_shells(config) && !has_tetrahedra(config)) {
    return free_shells_region(config, layout, nullptr, selections);
  }
  if (part.kind == Selection::Kind::surface) return surface_region(layout, part, selections);
  const bool is_rod = std::ranges::find(config.rods, part.name, &RodConfig::name) != config.rods.end();
  return volume_region(layout, left_out, part,
                       is_rod ? "; the fields of rods are rod_force, rod_bending_moment and rod_torque" : "",
                       selections);
}

}  // namespace

std::vector<FieldRegion> find_field_regions(const Config& config, const NodeLayout& layout,
                                            const std::vector<int>& body_of_cell, Selections& selections) {
  const std::vector<char> left_out = cells_without_mesh(config, body_of_cell);
  std::vector<FieldRegion> regions;
  for (const FieldColumnConfig& column : config.output.history) {
    const FieldOwner owner = field_component(column.of.value)->field.owner;
    FieldRegion region;
    if (column.at) {
      // A probe.
    } else if (owner == FieldOwner::shells) {
      region.parts = numbers_of(config.shells, column.in);
    } else if (owner == FieldOwner::rods) {
      region.parts = numbers_of(config.rods, column.in);
    } else {
      region = region_of(config, layout, left_out, column, selections);
    }
    regions.push_back(std::move(region));
  }
  return regions;
}

}  // namespace pliant
