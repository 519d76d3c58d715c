#include "collision/surface.hpp"

#include <algorithm>
#include <stdexcept>

namespace pliant {
namespace {

/// The numbers of the vertices that triangles name, sorted by key.
std::vector<SurfaceVertex> used_vertices(std::span<const SurfaceVertex> vertices,
                                         std::span<const SurfaceTriangle> triangles) {
  std::vector<VertexKey> used;
  used.reserve(3 * triangles.size());
  for (const auto& triangle : triangles) used.insert(used.end(), triangle.vertices.begin(), triangle.vertices.end());
  std::ranges::sort(used);
  used.erase(std::ranges::unique(used).begin(), used.end());
  std::vector<SurfaceVertex> sorted(vertices.begin(), vertices.end());
  std::ranges::sort(sorted, {}, &SurfaceVertex::key);
  if (std::ranges::adjacent_find(sorted, {}, &SurfaceVertex::key) != sorted.end()) {
    throw std::invalid_argument("two vertices of a collision surface have one key");
  }
  std::erase_if(sorted, [&](const SurfaceVertex& vertex) { return !std::ranges::binary_search(used, vertex.key); });
  if (sorted.size() != used.size())
    throw std::invalid_argument("a collision triangle names a vertex that is not there");
  return sorted;
}

}  // namespace

std::array<std::int32_t, 3> in_lasting_order(std::array<std::int32_t, 3> corners) {
  const auto [a, b, c] = corners;
  if (b == c) return {std::min(a, b), std::max(a, b), std::max(a, b)};
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  return corners;
}

CollisionSurface::CollisionSurface(std::span<const SurfaceVertex> vertices,
                                   std::span<const SurfaceTriangle> triangles) {
  const auto sorted = used_vertices(vertices, triangles);
  vertices_.resize(sorted.size());
  for (std::size_t n = 0; n < sorted.size(); ++n) {
    vertices_[n].key = sorted[n].key;
    rest_positions_.push_back(sorted[n].X);
  }
  for (const auto& given : triangles) {
    Triangle triangle{
        .body = given.body, .group = given.group, .rigid_part = given.rigid_part, .thickness = given.thickness};
    for (int k = 0; k < 3; ++k) {
      const auto place = std::ranges::lower_bound(sorted, given.vertices[k], {}, &SurfaceVertex::key);
      triangle.vertices[k] = static_cast<std::int32_t>(place - sorted.begin());
    }
    triangle.vertices = in_lasting_order(triangle.vertices);
    const auto [a, b, c] = triangle.vertices;
    const bool is_segment = b == c && triangle.is_thin();
    if (a == b || c == a || (b == c && !is_segment)) {
      throw std::invalid_argument("a collision triangle has a vertex twice");
    }
    const Vector3<double> ab = rest_positions_[b] - rest_positions_[a];
    triangle.area =
        is_segment ? triangle.thickness * norm(ab) : 0.5 * norm(cross(ab, rest_positions_[c] - rest_positions_[a]));
    triangles_.push_back(triangle);
  }
  std::ranges::sort(triangles_, {}, &Triangle::vertices);
  const auto is_repeated = [](const Triangle& one, const Triangle& next) {
    return next.is_segment() && one.vertices == next.vertices;
  };
  triangles_.erase(std::unique(triangles_.begin(), triangles_.end(), is_repeated), triangles_.end());
  number_edges();
  mark_flat_edges();
  for (const Triangle& triangle : triangles_) {
    for (const std::int32_t edge : triangle.sides()) {
      edges_[edge].area += triangle.area / static_cast<double>(triangle.sides().size());
    }
    for (const std::int32_t v : triangle.corners()) {
      vertices_[v].area += triangle.area / static_cast<double>(triangle.corners().size());
      vertices_[v].body = triangle.body;
    }
  }
  for (const Edge& edge : edges_) {
    longest_edge_ =
        std::max(longest_edge_, norm(rest_positions_[edge.vertices[1]] - rest_positions_[edge.vertices[0]]));
  }
}

void CollisionSurface::number_edges() {
  const auto ends = [](const Triangle& triangle, std::size_t k) {
    const auto [low, high] = std::minmax(triangle.vertices[k], triangle.vertices[(k + 1) % 3]);
    return std::array{low, high};
  };
  for (const Triangle& triangle : triangles_) {
    for (std::size_t k = 0; k < triangle.sides().size(); ++k) {
      edges_.push_back({.vertices = ends(triangle, k), .body = triangle.body, .is_loose = true});
    }
  }
  std::ranges::sort(edges_, {}, &Edge::vertices);
  edges_.erase(std::ranges::unique(edges_, {}, &Edge::vertices).begin(), edges_.end());
  for (Triangle& triangle : triangles_) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto of = ends(triangle, triangle.is_segment() ? 0 : k);
      const auto place = std::ranges::lower_bound(edges_, of, {}, &Edge::vertices);
      triangle.edges[k] = static_cast<std::int32_t>(place - edges_.begin());
      place->is_loose = place->is_loose && triangle.is_segment();
    }
  }
}

void CollisionSurface::mark_flat_edges() {
  constexpr double angle = 1e-7;  // of rounding errors in the coordinates
  struct Around {
    int number = 0;
    std::int32_t rigid_part = 0;
    Vector3<double> normal{};
    bool is_plane = true;
  };
  std::vector<Around> around(edges_.size());
  for (const Triangle& triangle : triangles_) {
    if (triangle.is_thin()) continue;
    const auto [a, b, c] = triangle.vertices;
    const Vector3<double> normal =
        unit(cross(rest_positions_[b] - rest_positions_[a], rest_positions_[c] - rest_positions_[a]));
    for (const std::int32_t edge : triangle.edges) {
      Around& at = around[edge];
      if (at.number++ == 0) {
        at.rigid_part = triangle.rigid_part;
        at.normal = normal;
      } else {
        at.is_plane = at.is_plane && at.rigid_part == triangle.rigid_part && norm(at.normal - normal) < angle;
      }
    }
  }
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    edges_[e].is_flat = around[e].number == 2 && around[e].rigid_part != 0 && around[e].is_plane;
  }
}

bool CollisionSurface::is_incident(const Triangle& triangle, std::int32_t vertex) const {
  return std::ranges::find(triangle.vertices, vertex) != triangle.vertices.end();
}

bool CollisionSurface::is_incident(const Edge& edge, const Edge& other) const {
  return edge.vertices[0] == other.vertices[0] || edge.vertices[0] == other.vertices[1] ||
         edge.vertices[1] == other.vertices[0] || edge.vertices[1] == other.vertices[1];
}

bool CollisionSurface::is_incident(const Triangle& triangle, const Triangle& other) const {
  return std::ranges::any_of(other.vertices, [&](std::int32_t vertex) { return is_incident(triangle, vertex); });
}

}  // namespace pliant
