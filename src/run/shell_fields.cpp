#include "run/shell_fields.hpp"

#include "fem/cell_integration.hpp"
#include "input/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace pliant {
namespace {

using Symmetric = std::array<double, 6>;

void add(Symmetric& sum, double weight, const Symmetric& part) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * part[k];
}

/// The facet's corners as global numbers, by which layers that lie on one another are found.
std::array<std::int64_t, 3> corners_of(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  std::array<std::int64_t, 3> corners{layout.global_node(nodes[0]), layout.global_node(nodes[1]),
                                      layout.global_node(nodes[2])};
  std::ranges::sort(corners);
  return corners;
}

/// The states of a facet of several layers.
struct Stack {
  LayerState sum;
  double area = 0.0, bent = 0.0;  // bent: how much of all layers' area the curvature is the sum over
  std::span<const PetscInt> nodes;
};

}  // namespace

std::array<double, 3> principal_values_in_layer(const std::array<double, 6>& T) {
  const double mean = 0.5 * (T[0] + T[1] + T[2]);
  const double squares = T[0] * T[0] + T[1] * T[1] + T[2] * T[2] + 2.0 * (T[3] * T[3] + T[4] * T[4] + T[5] * T[5]);
  // The third value is zero: T:T = 2 mean^2 + 2 radius^2.
  const double radius = std::sqrt(std::max(0.5 * squares - mean * mean, 0.0));
  return {mean + radius, mean - radius, 0.0};
}

ShellFields::ShellFields(const Config& config, Model& model)
    : model_(model), is_static_(analysis_of(config) == Analysis::static_equilibrium) {
  const NodeLayout& layout = model.layout();
  for (const ModelShell& shell : model.shells().shells) {
    std::vector<double>& areas = areas_.emplace_back();
    for (PetscInt f = 0; f < shell.facets.size(); ++f) {
      double& area = areas.emplace_back(0.0);
      for_each_point_of_facet(layout, shell.facets.nodes_of(f),
                              [&](const IntegrationPoint& point) { area += point.weight; });
    }
  }
}

std::vector<LayerFacet> ShellFields::of_facets(std::size_t number, const StepRecord& record) const {
  const ModelShell& shell = model_.shells().shells[number];
  const NodeLayout& layout = model_.layout();
  const Instant at = record.instant(model_);
  EnergyAccounts accounts = model_.potential().accounts();
  std::vector<LayerFacet> facets(static_cast<std::size_t>(shell.facets.size()));
  for (std::size_t f = 0; f < facets.size(); ++f) {
    facets[f].area = areas_[number][f];
    const auto nodes = shell.facets.nodes_of(static_cast<PetscInt>(f));
    const auto first = std::ranges::min_element(nodes.first(3), {}, [&](PetscInt n) { return layout.global_node(n); });
    facets[f].is_counted = *first < layout.num_owned_nodes;
  }
  std::vector<Symmetric> forces(facets.size(), Symmetric{});
  const BodyState state =
      accounts.state_of(*shell.membrane.elasticity, at, record.q, is_static_ ? nullptr : record.v, nullptr);
  shell.membrane.elasticity->add_forces_per_length(state.q, state.v, forces);
  if (shell.membrane.viscosity) shell.membrane.viscosity->add_forces_per_length(state.q, state.v, forces);
  for (std::size_t f = 0; f < facets.size(); ++f) facets[f].state.force = forces[f];
  if (!shell.bending) return facets;
  const BodyState bent = accounts.state_of(*shell.bending, at, record.q, nullptr, nullptr);
  if (bent.at.near == nullptr) return facets;
  std::vector<double> area_of_curvature(facets.size(), 0.0);
  shell.bending->visit(*bent.at.near, bent.q, [&](const BentTriangle& triangle) {
    const auto f = static_cast<std::size_t>(triangle.facet);
    add(facets[f].state.moment, triangle.area / facets[f].area, triangle.moment);
    if (!triangle.is_surrounded) return;
    add(facets[f].state.curvature, triangle.area, triangle.curvature);
    area_of_curvature[f] += triangle.area;
  });
  for (std::size_t f = 0; f < facets.size(); ++f) {
    facets[f].has_curvature = area_of_curvature[f] > 0.0;
    if (!facets[f].has_curvature) continue;
    for (double& entry : facets[f].state.curvature) entry /= area_of_curvature[f];
  }
  return facets;
}

std::vector<LayerState> ShellFields::at_nodes(
    const std::function<const std::vector<LayerFacet>&(std::size_t)>& of_shell) const {
  const NodeLayout& layout = model_.layout();
  std::map<std::array<std::int64_t, 3>, Stack> stacks;
  for (std::size_t s = 0; s < model_.shells().shells.size(); ++s) {
    const FacetList& list = model_.shells().shells[s].facets;
    const std::vector<LayerFacet>& facets = of_shell(s);
    for (std::size_t f = 0; f < facets.size(); ++f) {
      const auto nodes = list.nodes_of(static_cast<PetscInt>(f));
      Stack& stack = stacks[corners_of(layout, nodes)];
      stack.nodes = nodes;
      stack.area = facets[f].area;
      add(stack.sum.force, 1.0, facets[f].state.force);
      add(stack.sum.moment, 1.0, facets[f].state.moment);
      if (!facets[f].has_curvature) continue;
      add(stack.sum.curvature, facets[f].area, facets[f].state.curvature);
      stack.bent += facets[f].area;
    }
  }
  std::vector<LayerState> at_nodes(static_cast<std::size_t>(layout.num_local_nodes));
  std::vector<double> areas(at_nodes.size(), 0.0), bent(at_nodes.size(), 0.0);
  for (const auto& [corners, stack] : stacks) {
    for (const PetscInt node : stack.nodes) {
      const auto n = static_cast<std::size_t>(node);
      add(at_nodes[n].force, stack.area, stack.sum.force);
      add(at_nodes[n].moment, stack.area, stack.sum.moment);
      add(at_nodes[n].curvature, 1.0, stack.sum.curvature);
      areas[n] += stack.area;
      bent[n] += stack.bent;
    }
  }
  for (std::size_t n = 0; n < at_nodes.size(); ++n) {
    for (std::size_t k = 0; k < 6; ++k) {
      if (areas[n] > 0.0) at_nodes[n].force[k] /= areas[n];
      if (areas[n] > 0.0) at_nodes[n].moment[k] /= areas[n];
      if (bent[n] > 0.0) at_nodes[n].curvature[k] /= bent[n];
    }
  }
  return at_nodes;
}

}  // namespace pliant
