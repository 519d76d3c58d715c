#include "collision/surface_neighbours.hpp"

#include <algorithm>
#include <map>
#include <queue>

namespace pliant {
namespace {

struct Reached {
  double distance;
  std::int32_t vertex;
  friend auto operator<=>(const Reached&, const Reached&) = default;
};

/// Edges at each vertex: the vertex beyond, and the length at rest.
std::vector<std::vector<Reached>> edges_at_vertices(const CollisionSurface& surface) {
  std::vector<std::vector<Reached>> result(surface.vertices().size());
  const auto X = surface.rest_positions();
  for (const auto& edge : surface.edges()) {
    const auto [a, b] = edge.vertices;
    const double length = norm(X[b] - X[a]);
    result[a].push_back({length, b});
    result[b].push_back({length, a});
  }
  return result;
}

/// The vertices within a distance along edges, with their distances (Dijkstra).
std::map<std::int32_t, double> within(const std::vector<std::vector<Reached>>& edges, std::int32_t from,
                                      double distance) {
  std::map<std::int32_t, double> nearest;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  next.push({0.0, from});
  while (!next.empty()) {
    const Reached at = next.top();
    next.pop();
    if (!nearest.try_emplace(at.vertex, at.distance).second) continue;
    for (const auto& [length, beyond] : edges[at.vertex]) {
      if (at.distance + length <= distance && !nearest.contains(beyond)) next.push({at.distance + length, beyond});
    }
  }
  return nearest;
}

}  // namespace

SurfaceNeighbours::SurfaceNeighbours(const CollisionSurface& surface, int num_bodies, std::vector<double> distances) {
  if (std::ranges::none_of(distances, [](double distance) { return distance > 0.0; })) return;
  const auto n = static_cast<std::size_t>(num_bodies);
  const auto edges = edges_at_vertices(surface);
  const auto vertices = surface.vertices();
  begins_.push_back(0);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const auto of_body = std::span(distances).subspan(n * static_cast<std::size_t>(vertices[v].body), n);
    for (const auto& [other, distance] : within(edges, static_cast<std::int32_t>(v), std::ranges::max(of_body))) {
      if (static_cast<std::size_t>(other) != v && distance <= of_body[vertices[other].body]) lists_.push_back(other);
    }
    begins_.push_back(static_cast<std::int32_t>(lists_.size()));
  }
}

bool SurfaceNeighbours::find(std::span<const std::int32_t> vertices, std::span<const std::int32_t> others) const {
  return std::ranges::any_of(vertices, [&](std::int32_t v) {
    const auto list = std::span(lists_).subspan(begins_[v], begins_[v + 1] - begins_[v]);
    return std::ranges::any_of(others, [&](std::int32_t w) { return std::ranges::binary_search(list, w); });
  });
}

}  // namespace pliant
