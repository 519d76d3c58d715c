#include "run/shell_fields.hpp"

#include "fem/cell_integration.hpp"
#include "fem/facet_triangles.hpp"
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

/// The nodes of the triangles of a facet.
std::vector<std::array<PetscInt, 3>> triangles_of(std::span<const PetscInt> nodes) {
  std::vector<std::array<PetscInt, 3>> result;
  for (const auto& [a, b, c] : triangles_of_facet(static_cast<int>(nodes.size()))) {
    result.push_back(
        {nodes[static_cast<std::size_t>(a)], nodes[static_cast<std::size_t>(b)], nodes[static_cast<std::size_t>(c)]});
  }
  return result;
}

double area_of(const NodeLayout& layout, const std::array<PetscInt, 3>& nodes) {
  const Vector3<double> a = layout.position(nodes[0]), b = layout.position(nodes[1]), c = layout.position(nodes[2]);
  return 0.5 * norm(cross(b - a, c - a));
}

/// A triangle's corners as global numbers, by which layers that lie on one another are found.
std::array<std::int64_t, 3> corners_of(const NodeLayout& layout, const std::array<PetscInt, 3>& nodes) {
  std::array<std::int64_t, 3> corners{layout.global_node(nodes[0]), layout.global_node(nodes[1]),
                                      layout.global_node(nodes[2])};
  std::ranges::sort(corners);
  return corners;
}

/// The states of a triangle of several layers.
struct Stack {
  LayerState sum;
  double area = 0.0, bent = 0.0;  // bent: how much of all layers' area the curvature is the sum over
  std::array<PetscInt, 3> nodes{};
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
      double whole = 0.0, flat = 0.0;
      for_each_point_of_facet(layout, shell.facets.nodes_of(f),
                              [&](const IntegrationPoint& point) { whole += point.weight; });
      const auto triangles = triangles_of(shell.facets.nodes_of(f));
      for (const auto& nodes : triangles) flat += area_of(layout, nodes);
      for (const auto& nodes : triangles) areas.push_back(whole * area_of(layout, nodes) / flat);
    }
  }
}

std::vector<LayerTriangle> ShellFields::of_triangles(std::size_t number, const StepRecord& record) const {
  const ModelShell& shell = model_.shells().shells[number];
  const NodeLayout& layout = model_.layout();
  const Instant at = record.instant(model_);
  EnergyAccounts accounts = model_.potential().accounts();
  std::vector<Symmetric> forces(static_cast<std::size_t>(shell.facets.size()), Symmetric{});
  const BodyState state =
      accounts.state_of(*shell.membrane.elasticity, at, record.q, is_static_ ? nullptr : record.v, nullptr);
  shell.membrane.elasticity->add_forces_per_length(state.q, state.v, forces);
  if (shell.membrane.viscosity) shell.membrane.viscosity->add_forces_per_length(state.q, state.v, forces);
  const std::size_t per_facet = triangles_of_facet(shell.facets.nodes_per_facet).size();
  std::vector<LayerTriangle> triangles(areas_[number].size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::size_t f = t / per_facet;
    const auto nodes = shell.facets.nodes_of(static_cast<PetscInt>(f));
    const auto first = std::ranges::min_element(nodes.first(3), {}, [&](PetscInt n) { return layout.global_node(n); });
    triangles[t].area = areas_[number][t];
    triangles[t].is_counted = *first < layout.num_owned_nodes;
    triangles[t].state.force = forces[f];
  }
  if (!shell.bending) return triangles;
  const BodyState bent = accounts.state_of(*shell.bending, at, record.q, nullptr, nullptr);
  if (bent.at.near == nullptr) return triangles;
  shell.bending->visit(*bent.at.near, bent.q, [&](const BentTriangle& of) {
    LayerTriangle& triangle = triangles[static_cast<std::size_t>(of.number)];
    triangle.state.moment = of.moment;
    triangle.has_curvature = of.is_surrounded;
    if (of.is_surrounded) triangle.state.curvature = of.curvature;
  });
  return triangles;
}

std::vector<LayerState> ShellFields::at_nodes(
    const std::function<const std::vector<LayerTriangle>&(std::size_t)>& of_shell) const {
  const NodeLayout& layout = model_.layout();
  std::map<std::array<std::int64_t, 3>, Stack> stacks;
  for (std::size_t s = 0; s < model_.shells().shells.size(); ++s) {
    const FacetList& list = model_.shells().shells[s].facets;
    const std::vector<LayerTriangle>& triangles = of_shell(s);
    std::size_t t = 0;
    for (PetscInt f = 0; f < list.size(); ++f) {
      for (const auto& nodes : triangles_of(list.nodes_of(f))) {
        const LayerTriangle& triangle = triangles[t++];
        Stack& stack = stacks[corners_of(layout, nodes)];
        stack.nodes = nodes;
        stack.area = triangle.area;
        add(stack.sum.force, 1.0, triangle.state.force);
        add(stack.sum.moment, 1.0, triangle.state.moment);
        if (!triangle.has_curvature) continue;
        add(stack.sum.curvature, triangle.area, triangle.state.curvature);
        stack.bent += triangle.area;
      }
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
