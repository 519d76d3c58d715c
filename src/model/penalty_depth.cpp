#include "model/penalty_depth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr double deepest_per_facet = 0.25, deepest_per_thickness = 0.4;
constexpr int most_parts_of_step = 64;

/// Twice the volume over the surface, of the thinnest body with a closed surface: the thickness of a plate, a third of
/// the edge of a cube [m].
double least_thickness(const CollisionSurface& surface, std::size_t num_bodies) {
  struct Extent {
    double volume = 0.0, area = 0.0;
    std::size_t num_sides = 0, num_edges = 0;
  };
  std::vector<Extent> extents(num_bodies);
  const auto x = surface.rest_positions();
  for (const auto& triangle : surface.triangles()) {
    const auto [a, b, c] = triangle.vertices;
    Extent& extent = extents[static_cast<std::size_t>(triangle.body)];
    extent.volume += dot(x[a] - x[0], cross(x[b] - x[0], x[c] - x[0])) / 6.0;
    extent.area += triangle.area;
    extent.num_sides += 3;
  }
  for (const auto& edge : surface.edges()) ++extents[static_cast<std::size_t>(edge.body)].num_edges;
  double least = std::numeric_limits<double>::infinity();
  for (const Extent& extent : extents) {
    const bool is_closed = extent.area > 0.0 && extent.num_sides == 2 * extent.num_edges;
    if (is_closed && extent.volume > 0.0) least = std::min(least, 2.0 * extent.volume / extent.area);
  }
  return least;
}

}  // namespace

double depth_of_penalty(const CollisionSurface& surface, std::size_t num_bodies, double facet_size) {
  return std::min(deepest_per_facet * facet_size, deepest_per_thickness * least_thickness(surface, num_bodies));
}

std::vector<SurfaceOverlap> deep_overlaps(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                                          const ContactSets& sets, double depth) {
  auto found = find_overlaps(surface, x, sets);
  std::erase_if(found, [&](const SurfaceOverlap& overlap) {
    return overlap.body == overlap.other || overlap.depth < too_deep * depth;
  });
  return found;
}

std::optional<SurfaceOverlap> deep_overlap_on_way(const CollisionSurface& surface, const SurfaceMotion& motion,
                                                  const ContactSets& sets, double depth) {
  // Bodies approach each other by twice the motion of each.
  const double wanted = std::ceil(2.0 * motion.farthest / (too_deep * depth));
  const int parts = static_cast<int>(std::clamp(wanted, 1.0, double(most_parts_of_step)));
  std::vector<Vector3<double>> x(motion.to.size());
  for (int n = 1; n <= parts; ++n) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      x[v] = motion.from[v] + (double(n) / parts) * (motion.to[v] - motion.from[v]);
    }
    const auto found = deep_overlaps(surface, x, sets, depth);
    if (!found.empty()) return found.front();
  }
  return std::nullopt;
}

}  // namespace pliant
