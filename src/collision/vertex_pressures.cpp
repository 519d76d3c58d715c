#include "collision/vertex_pressures.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Part of a vertex' area that carries the force on it at the least, where that is along the surface.
constexpr double least_facing_area = 0.25;

}  // namespace

std::vector<double> vertex_pressures(const CollisionSurface& surface, std::span<const std::int32_t> triangles,
                                     std::span<const Vector3<double>> x, std::span<const Vector3<double>> slopes) {
  std::vector<double> facing(surface.vertices().size(), 0.0);  // areas, as vectors along the slopes
  for (const std::int32_t number : triangles) {
    const auto& triangle = surface.triangles()[number];
    if (triangle.is_segment()) {
      for (const std::int32_t vertex : triangle.corners()) facing[vertex] += 0.5 * triangle.area * norm(slopes[vertex]);
      continue;
    }
    const auto [a, b, c] = triangle.vertices;
    const Vector3<double> normal = cross(x[b] - x[a], x[c] - x[a]);
    const double size = norm(normal);
    for (const std::int32_t vertex : triangle.vertices) {
      if (!(size > 0.0)) continue;
      const double along = dot(normal, slopes[vertex]) / size;
      facing[vertex] += triangle.area / 3.0 * (triangle.is_thin() ? std::abs(along) : std::max(0.0, along));
    }
  }
  std::vector<double> pressures(surface.vertices().size(), 0.0);
  for (std::size_t vertex = 0; vertex < pressures.size(); ++vertex) {
    const double force = norm(slopes[vertex]);
    if (force == 0.0) continue;
    const double least = least_facing_area * surface.vertices()[vertex].area;
    pressures[vertex] = force / std::max(least, facing[vertex] / force);
  }
  return pressures;
}

}  // namespace pliant
