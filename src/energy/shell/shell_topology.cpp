#include "energy/shell/shell_topology.hpp"

#include "base/orientation.hpp"

#include <algorithm>

namespace pliant {

ShellTopology::ShellTopology(std::vector<Triangle> triangles, std::span<const ClampedEdge> clamped)
    : triangles_(std::move(triangles)) {
  orient(triangles_);
  std::map<std::pair<std::int64_t, std::int64_t>, const ClampedEdge*> is_clamped;
  for (const ClampedEdge& edge : clamped) is_clamped.emplace(std::pair(edge.nodes[0], edge.nodes[1]), &edge);
  edge_at_.assign(triangles_.size(), {-1, -1, -1});
  for (const auto& [ends, edge] : is_clamped) ++num_unclamped_[edge->source];
  for (const auto& [ends, sides] : sides_of_edges()) {
    if (sides.size() > 2) continue;
    Edge edge{{sides.front(), {}}, true, {}};
    if (sides.size() == 2) {
      edge.sides[1] = sides[1];
      const auto start = [&](const Side& side) { return triangles_[static_cast<std::size_t>(side.triangle)][side.k]; };
      edge.is_oriented = start(sides[0]) != start(sides[1]);
    } else {
      const auto found = is_clamped.find(ends);
      if (found == is_clamped.end()) continue;
      edge.clamped = *found->second;
      const auto left = num_unclamped_.find(found->second->source);
      if (--left->second == 0) num_unclamped_.erase(left);
    }
    for (const Side& side : sides) {
      edge_at_[static_cast<std::size_t>(side.triangle)][side.k] = static_cast<std::int64_t>(edges_.size());
    }
    edges_.push_back(edge);
  }
}

ShellTopology::SidesOfEdges ShellTopology::sides_of_edges() const {
  SidesOfEdges result;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto ends = std::minmax(triangles_[t][k], triangles_[t][(k + 1) % 3]);
      result[ends].push_back({static_cast<std::int64_t>(t), k});
    }
  }
  return result;
}

ShellTopology::Side ShellTopology::across(std::size_t triangle, std::size_t k) const {
  const std::int64_t number = edge_at_[triangle][k];
  if (number < 0) return {};
  const Edge& edge = edges_[static_cast<std::size_t>(number)];
  return edge.sides[edge.sides[0].triangle == static_cast<std::int64_t>(triangle) ? 1 : 0];
}

std::vector<std::int64_t> ShellTopology::patch(std::size_t triangle) const {
  std::vector<std::int64_t> result{static_cast<std::int64_t>(triangle)};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int64_t neighbour = across(triangle, k).triangle;
    if (neighbour < 0) continue;
    result.push_back(neighbour);
    for (std::size_t j = 0; j < 3; ++j) {
      const std::int64_t next = across(static_cast<std::size_t>(neighbour), j).triangle;
      if (next >= 0) result.push_back(next);
    }
  }
  std::ranges::sort(result);
  result.erase(std::ranges::unique(result).begin(), result.end());
  return result;
}

}  // namespace pliant
