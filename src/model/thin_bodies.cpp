#include "model/thin_bodies.hpp"

#include "energy/contact/body_surfaces.hpp"
#include "model/shells.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace pliant {
namespace {

double thickness_of_rod(const RodConfig& rod) {
  return rod.section ? std::min(rod.section->width, rod.section->height) : 2.0 * rod.radius.value_or(0.0);
}

/// The places of bodies among those of the input.
template <class Config>
const Config* named(const std::vector<Config>& all, const std::string& name) {
  const auto found = std::ranges::find_if(all, [&](const Config& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}

/// The nodes of solids on all ranks that also belong to rods. Collective.
std::set<PetscInt> nodes_in_solids(const Config& config, const NodeLayout& layout,
                                   const std::vector<int>& body_of_cell) {
  std::vector<char> is_of_rod(static_cast<std::size_t>(layout.num_owned_nodes), 0), is_of_solid(is_of_rod);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const int body = body_of_cell[static_cast<std::size_t>(c)];
    if (body < 0) continue;
    const BodyConfig& of = config.bodies[static_cast<std::size_t>(body)];
    for (const PetscInt node : layout.nodes_of_cell(c)) {
      if (node >= layout.num_owned_nodes || of.is_shell) continue;
      (of.is_rod ? is_of_rod : is_of_solid)[static_cast<std::size_t>(node)] = 1;
    }
  }
  std::vector<PetscInt> mine;
  for (PetscInt node = 0; node < layout.num_owned_nodes; ++node) {
    const auto n = static_cast<std::size_t>(node);
    if (is_of_rod[n] != 0 && is_of_solid[n] != 0) mine.push_back(layout.global_node(node));
  }
  const auto all = gathered(layout.comm, mine);
  return {all.begin(), all.end()};
}

/// The local cells of rods by each two of their corners.
std::map<std::array<PetscInt, 2>, PetscInt> cells_by_ends(const NodeLayout& layout,
                                                          const std::vector<int>& body_of_cell,
                                                          const std::vector<char>& is_rod) {
  std::map<std::array<PetscInt, 2>, PetscInt> cells;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const int body = body_of_cell[static_cast<std::size_t>(c)];
    if (body < 0 || is_rod[static_cast<std::size_t>(body)] == 0) continue;
    const auto corners = layout.nodes_of_cell(c).first(4);
    for (const PetscInt a : corners) {
      for (const PetscInt b : corners) cells.insert({{a, b}, c});
    }
  }
  return cells;
}

void add_segments(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                  const ModelRods& rods, ThinBodies& thin) {
  thin.segments.nodes_per_facet = layout.order == 1 ? 3 : 6;
  if (!rods.term) return;
  const std::set<PetscInt> in_solids = nodes_in_solids(config, layout, body_of_cell);
  const auto cells = cells_by_ends(layout, body_of_cell, thin.is_rod);
  const auto is_within = [&](PetscInt node) { return in_solids.contains(layout.global_node(node)); };
  for (const Rods::SegmentNodes& segment : rods.term->segments_here()) {
    const bool is_part_of_rod = std::ranges::any_of(rods.rods, [&](const ModelRod& rod) {
      return segment.number >= rod.first_segment && segment.number < rod.first_segment + rod.num_segments();
    });
    const PetscInt a = segment.nodes[0], b = segment.nodes[1];
    const auto cell = cells.find({a, b});
    if (!is_part_of_rod || cell == cells.end() || (is_within(a) && is_within(b))) continue;
    const auto nodes = segment_as_facet(a, b, thin.segments.nodes_per_facet);
    thin.segments.nodes.insert(thin.segments.nodes.end(), nodes.begin(), nodes.end());
    thin.segments.is_owned.push_back(segment.is_counted ? 1 : 0);
    thin.segments.is_outer.push_back(1);
    thin.cells.push_back(cell->second);
  }
}

}  // namespace

ThinBodies find_thin_bodies(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                            const ModelRods& rods) {
  ThinBodies thin;
  for (const BodyConfig& body : config.bodies) {
    const std::string& name = body.part.name;
    const RodConfig* rod = body.is_rod ? named(config.rods, name) : nullptr;  // nullptr: a section at its end
    const ShellConfig* shell = body.is_shell ? named(config.shells, name) : nullptr;
    thin.names.push_back(name);
    thin.is_rod.push_back(rod != nullptr ? 1 : 0);
    thin.shear_moduli.push_back(rod != nullptr ? 0.5 * rod->youngs_modulus / (1.0 + rod->poissons_ratio) : 0.0);
    thin.thickness.push_back(rod != nullptr     ? thickness_of_rod(*rod)
                             : shell != nullptr ? thickness_at_start(*shell)
                                                : 0.0);
  }
  for (const RigidBodyConfig& body : config.rigid_bodies) {
    std::vector<std::string> held;
    for (const RodConfig& rod : config.rods) {
      if (rod.holder(0) == body.name || rod.holder(1) == body.name) held.push_back(rod.name);
    }
    if (body.surface && !held.empty()) thin.held.emplace_back(body.name, std::move(held));
  }
  add_segments(config, layout, body_of_cell, rods, thin);
  std::vector<double> num_segments(thin.names.size(), 0.0);
  for (const PetscInt cell : thin.cells) {
    num_segments[static_cast<std::size_t>(body_of_cell[static_cast<std::size_t>(cell)])] += 1.0;
  }
  sum_in_place(layout.comm, num_segments);
  for (std::size_t b = 0; b < num_segments.size(); ++b) {
    if (num_segments[b] == 0.0) thin.shear_moduli[b] = 0.0;
  }
  return thin;
}

FacetList with_segments(FacetList facets, const ThinBodies& thin) {
  const FacetList& segments = thin.segments;
  facets.nodes.insert(facets.nodes.end(), segments.nodes.begin(), segments.nodes.end());
  facets.is_owned.insert(facets.is_owned.end(), segments.is_owned.begin(), segments.is_owned.end());
  facets.is_outer.insert(facets.is_outer.end(), segments.is_outer.begin(), segments.is_outer.end());
  return facets;
}

}  // namespace pliant
