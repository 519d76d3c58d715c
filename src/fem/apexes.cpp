#include "fem/apexes.hpp"

#include "fem/element.hpp"

#include <algorithm>

namespace pliant {

std::size_t apex_of_cell(const NodeLayout& layout, PetscInt cell) {
  const auto corners = layout.nodes_of_cell(cell).first(4);
  const auto number = [&](PetscInt node) { return layout.vertex_numbers[static_cast<std::size_t>(node)]; };
  return static_cast<std::size_t>(std::ranges::max_element(corners, {}, number) - corners.begin());
}

std::vector<PetscInt> inert_nodes_of_cell(const NodeLayout& layout, PetscInt cell) {
  const auto nodes = layout.nodes_of_cell(cell);
  const std::size_t apex = apex_of_cell(layout, cell);
  std::vector<PetscInt> result{nodes[apex]};
  for (std::size_t e = 0; nodes.size() > 4 && e < tet_edges.size(); ++e) {
    const auto [from, to] = tet_edges[e];
    if (static_cast<std::size_t>(from) == apex || static_cast<std::size_t>(to) == apex) result.push_back(nodes[4 + e]);
  }
  return result;
}

std::vector<InertNode> inert_nodes(const NodeLayout& layout, std::span<const char> is_shell) {
  std::vector<InertNode> result;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (is_shell[static_cast<std::size_t>(c)] == 0) continue;
    const auto nodes = layout.nodes_of_cell(c);
    const std::size_t apex = apex_of_cell(layout, c);
    InertNode of_apex{nodes[apex], {}, {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}};
    for (std::size_t i = 0, k = 0; i < 4; ++i) {
      if (i != apex) of_apex.corners[k++] = nodes[i];
    }
    result.push_back(of_apex);
    for (std::size_t e = 0; nodes.size() > 4 && e < tet_edges.size(); ++e) {
      const auto a = static_cast<std::size_t>(tet_edges[e][0]), b = static_cast<std::size_t>(tet_edges[e][1]);
      if (a != apex && b != apex) continue;
      InertNode middle = of_apex;
      middle.node = nodes[4 + e];
      middle.height = 0.5;
      for (std::size_t k = 0; k < 3; ++k) {
        middle.weights[k] = 1.0 / 6.0 + (middle.corners[k] == nodes[a == apex ? b : a] ? 0.5 : 0.0);
      }
      result.push_back(middle);
    }
  }
  std::ranges::sort(result, {}, &InertNode::node);
  return result;
}

}  // namespace pliant
