#include "model/shells.hpp"

#include "fem/apexes.hpp"
#include "input/checks/volumetric.hpp"
#include "input/elasticity.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

namespace pliant {
namespace {

LayerShape shape_of(const ShellConfig& config) {
  LayerShape shape{config.thickness, {1.0, 1.0}, config.direction};
  if (!config.prestretch.empty()) shape.stretch = {config.prestretch.front(), config.prestretch.back()};
  return shape;
}

/// The area of the facets that this rank owns [m^2].
double owned_area(const NodeLayout& layout, const FacetList& facets) {
  const std::vector<double> areas = lumped_masses_of_layer(layout, facets, 1.0);
  double area = 0.0;
  for (std::size_t k = 0; k < areas.size(); ++k) {
    if (facets.is_owned[k / static_cast<std::size_t>(facets.nodes_per_facet)] != 0) area += areas[k];
  }
  return area;
}

void require_compressible_layer(const ElasticLawSpec& law, const ShellConfig& config) {
  if (!is_incompressible(law)) return;
  throw InputError(config.elasticity.where,
                   fmt::format("the thickness of shell '{}' follows from its law, which therefore must be "
                               "compressible: use a Poisson's ratio such as 0.4999; plane stress does not lock",
                               config.name));
}

MembraneTerms membrane_of(const ShellConfig& config, const NodeLayout& layout, const BlockPattern& pattern,
                          const FacetList& facets) {
  const ElasticityRule rule(config.elasticity);
  LayerMaterial material{rule.kind(), {}, viscosity_of(config)};
  const auto law_at = [&](const std::array<double, 3>& X) {
    ElasticLawSpec law = rule.law_at(0, X);
    require_compressible_layer(law, config);
    return law;
  };
  if (rule.is_uniform()) {
    material.law = law_at({});
  } else {
    material.law_at = law_at;
  }
  try {
    return make_membrane(layout, pattern, facets, shape_of(config), material);
  } catch (const std::domain_error&) {
    throw InputError(config.where,
                     fmt::format("the 'direction' of shell '{}' is at right angles to a facet of its surface, and has "
                                 "no part in it: choose a direction along the surface, or give parts of the surface "
                                 "shells of their own",
                                 config.name));
  }
}

/// D = E h^3 / (12 (1 - nu^2)) of the thickness h that the layer has on the surface.
std::unique_ptr<ShellBending> bending_of(const ShellConfig& config, const NodeLayout& layout, const ModelShell& shell) {
  const ElasticityRule rule(config.elasticity);
  const double h = thickness_at_start(config);
  const auto stiffness = [&](const std::array<double, 3>& X) {
    const ElasticLawSpec law = rule.law_at(0, X);
    require_compressible_layer(law, config);
    const Lame rest = law.at_rest().value();  // of laws without fibres
    const double nu = poissons_ratio(rest), E = 2.0 * rest.mu * (1.0 + nu);
    return BendingStiffness{E * h * h * h / (12.0 * (1.0 - nu * nu)), nu};
  };
  auto bending = std::make_unique<ShellBending>(layout, shell.facets, stiffness, shell.clamped);
  for (const auto& [k, number] : bending->num_unclamped()) {
    const ClampedEdgeConfig& edge = config.clamped[static_cast<std::size_t>(k)];
    throw InputError(edge.where, fmt::format("{} edges of {} do not bound shell '{}': name curves at its edge", number,
                                             describe(edge.part), config.name));
  }
  return bending;
}

/// Strain at a distance z from the middle is z k: int z^2 dz = h^3/12.
std::unique_ptr<ShellBendingViscosity> bending_viscosity_of(const ShellConfig& config, const ShellBending& bending) {
  const LayerViscosity viscosity = viscosity_of(config);
  if (!viscosity.is_any()) return nullptr;
  const double h = thickness_at_start(config), inertia = h * h * h / 12.0;
  return std::make_unique<ShellBendingViscosity>(
      bending, BendingResistance{viscosity.damping, inertia * viscosity.trace(), inertia * 2.0 * viscosity.shear});
}

/// Reports a plane of symmetry in which the edges do not lie.
void check_plane(const NodeLayout& layout, const EdgeList& edges, const Vector3<double>& normal, const Selection& part,
                 Selections& selections) {
  constexpr double most = 0.1;  // of a curve that is nearly in the plane
  bool leaves = false;
  for (std::size_t k = 0; k < edges.nodes.size(); k += static_cast<std::size_t>(edges.nodes_per_edge)) {
    const Vector3<double> e = layout.position(edges.nodes[k + 1]) - layout.position(edges.nodes[k]);
    leaves = leaves || std::abs(dot(e, normal)) > most * norm(e);
  }
  if (!any_rank(layout.comm, leaves)) return;
  selections.report(
      part.where, fmt::format("{} does not lie in a plane with the `normal` ({:g}, {:g}, {:g}): give that of the plane "
                              "of symmetry that holds the curve",
                              describe(part), normal[0], normal[1], normal[2]));
}

}  // namespace

double thickness_at_start(const ShellConfig& config) {
  return shape_of(config).volume_per_area();
}

LayerViscosity viscosity_of(const ShellConfig& config) {
  LayerViscosity result{config.damping, 0.0, 0.0};
  for (const ViscosityConfig& mechanism : config.viscosity) {
    if (const auto* proportional = std::get_if<StiffnessProportional>(&mechanism.law)) {
      result.damping += proportional->time;
    } else if (const auto* newtonian = std::get_if<KelvinVoigt>(&mechanism.law)) {
      result.shear += newtonian->shear;
      result.bulk += newtonian->bulk;
    }
  }
  return result;
}

bool has_free_shells(const Config& config) {
  return std::ranges::any_of(config.shells, &ShellConfig::is_free);
}

void add_bodies_of_shells(Config& config) {
  for (const ShellConfig& shell : config.shells) {
    if (!shell.is_free) continue;
    BodyConfig& body = config.bodies.emplace_back();
    body.part.kind = Selection::Kind::volume;
    body.part.name = shell.name;
    body.part.where = shell.where;
    body.is_shell = true;
    body.where = shell.where;
  }
}

std::vector<AddedShell> added_shells(const Config& config) {
  std::vector<AddedShell> result;
  for (const ShellConfig& shell : config.shells) {
    if (shell.is_free) result.push_back({shell.name, shell.part.name, shell.part.where});
  }
  return result;
}

std::vector<char> cells_of_free_shells(const Config& config, const std::vector<int>& body_of_cell) {
  if (!has_free_shells(config)) return {};
  std::vector<char> result;
  for (const int body : body_of_cell) {
    result.push_back(body >= 0 && config.bodies[static_cast<std::size_t>(body)].is_shell ? 1 : 0);
  }
  return result;
}

// The foot of the apex is the middle of its triangle.
void move_to_triangles(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                       std::span<ProbeLocation> locations) {
  const std::vector<char> is_shell = cells_of_free_shells(config, body_of_cell);
  if (is_shell.empty()) return;
  const std::vector<InertNode> inert = inert_nodes(layout, is_shell);
  for (ProbeLocation& location : locations) {
    ProbeLocation moved;
    moved.cell = location.cell;
    moved.distance = location.distance;
    for (std::size_t a = 0; a < location.nodes.size(); ++a) {
      const auto found = std::ranges::lower_bound(inert, location.nodes[a], {}, &InertNode::node);
      if (found == inert.end() || found->node != location.nodes[a]) {
        moved.nodes.push_back(location.nodes[a]);
        moved.weights.push_back(location.weights[a]);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        moved.nodes.push_back(found->corners[k]);
        moved.weights.push_back(location.weights[a] * found->weights[k]);
      }
    }
    location = std::move(moved);
  }
}

ModelShells find_shells(const Config& config, const NodeLayout& layout, Selections& selections) {
  ModelShells result;
  for (const ShellConfig& shell : config.shells) {
    ModelShell& on_mesh = result.shells.emplace_back();
    on_mesh.name = shell.name;
    on_mesh.facets = selections.facets(shell.part);
    for (const ClampedEdgeConfig& edge : shell.clamped) {
      ClampedEdges& edges = on_mesh.clamped.emplace_back();
      edges.edges = selections.edges(edge.part);
      if (!edge.normal) continue;
      edges.normal = unit(Vector3<double>(*edge.normal));
      check_plane(layout, edges.edges, *edges.normal, edge.part, selections);
    }
    on_mesh.mass_per_area = shell.density.value_or(0.0) * thickness_at_start(shell);
    on_mesh.area = sum(layout.comm, owned_area(layout, on_mesh.facets));
    const auto owned = std::ranges::count_if(on_mesh.facets.is_owned, [](char is_owned) { return is_owned != 0; });
    on_mesh.num_facets = sum(layout.comm, static_cast<PetscInt64>(owned));
  }
  return result;
}

void build_shells(const Config& config, const NodeLayout& layout, const BlockPattern& pattern, ModelShells& shells) {
  on_every_rank(layout.comm, [&] {
    for (std::size_t k = 0; k < shells.shells.size(); ++k) {
      ModelShell& shell = shells.shells[k];
      shell.membrane = membrane_of(config.shells[k], layout, pattern, shell.facets);
    }
  });
  for (std::size_t k = 0; k < shells.shells.size(); ++k) {
    ModelShell& shell = shells.shells[k];
    if (!config.shells[k].bends) continue;
    shell.bending = bending_of(config.shells[k], layout, shell);
    shell.bending_viscosity = bending_viscosity_of(config.shells[k], *shell.bending);
  }
}

void add_masses_of_shells(const NodeLayout& layout, const BlockPattern& pattern, MassKind kind,
                          const ModelShells& shells, MassMatrix& mass) {
  for (const ModelShell& shell : shells.shells) {
    if (shell.mass_per_area == 0.0) continue;
    add_masses_of_layer(layout, pattern, shell.facets, shell.mass_per_area,
                        kind == MassKind::consistent ? Mass::consistent : Mass::lumped, mass);
  }
}

}  // namespace pliant
