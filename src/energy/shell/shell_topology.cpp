#include "energy/shell/shell_topology.hpp"

#include <algorithm>

namespace pliant {

ShellTopology::ShellTopology(std::vector<Triangle> triangles, std::span<const ClampedEdge> clamped)
    : triangles_(std::move(triangles)) {
  orient(sides_of_edges());
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

void ShellTopology::orient(const SidesOfEdges& sides) {
  std::vector<char> is_done(triangles_.size(), 0);
  std::vector<std::size_t> waiting;
  // From a triangle whose orientation is settled to those beyond its sides.
  const auto settle_neighbours = [&](std::size_t t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t from = triangles_[t][k], to = triangles_[t][(k + 1) % 3];
      const auto& both = sides.at(std::minmax(from, to));
      if (both.size() != 2) continue;
      const auto other = static_cast<std::size_t>(both[0].triangle == static_cast<std::int64_t>(t) ? both[1].triangle
                                                                                                   : both[0].triangle);
      if (is_done[other] != 0) continue;
      Triangle& nodes = triangles_[other];
      const auto place = static_cast<std::size_t>(std::ranges::find(nodes, from) - nodes.begin());
      if (nodes[(place + 1) % 3] == to) std::swap(nodes[1], nodes[2]);
      is_done[other] = 1;
      waiting.push_back(other);
    }
  };
  for (std::size_t first = 0; first < triangles_.size(); ++first) {
    if (is_done[first] != 0) continue;
    is_done[first] = 1;
    waiting.push_back(first);
    while (!waiting.empty()) {
      const std::size_t t = waiting.back();
      waiting.pop_back();
      settle_neighbours(t);
    }
  }
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
