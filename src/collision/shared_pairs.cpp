#include "collision/shared_pairs.hpp"

#include "collision/closest_points.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Facets have a share up to this part of the distance beyond the nearest, and below this angle to it.
constexpr double about_as_near = 0.1;
constexpr double least_cosine = 0.5;

/// The foot of a point within a facet.
struct FacetFoot {
  double distance = 0.0, from_rim = 0.0;  // from_rim: the least barycentric coordinate, 0 where it is on the rim
  std::int8_t side = 0;
  Vector3<double> normal{};
};

FacetFoot foot_on(const CollisionSurface& surface, std::int32_t facet, const Vector3<double>& p,
                  std::span<const Vector3<double>> x) {
  const auto [a, b, c] = surface.triangles()[facet].vertices;
  const PointTriangle closest = closest_point_triangle(std::array{p, x[a], x[b], x[c]});
  if (closest.feature != TriangleFeature::face) return {};
  const Vector3<double> normal = unit(cross(x[b] - x[a], x[c] - x[a]));
  return {.distance = std::sqrt(closest.squared_distance),
          .from_rim = std::ranges::min(closest.barycentric),
          .side = static_cast<std::int8_t>(dot(normal, p - x[a]) < 0.0 ? -1 : 1),
          .normal = normal};
}

}  // namespace

std::vector<SharedPair> shared_pairs(const CollisionSurface& surface, std::span<const SurfacePoint> points,
                                     std::span<const PointPair> nearest, std::span<const BoxPair> candidates,
                                     std::span<const Vector3<double>> x) {
  std::vector<SharedPair> shared;
  auto of_point = candidates.begin();
  for (const PointPair& pair : nearest) {
    const std::size_t first = shared.size();
    shared.push_back({pair});
    while (of_point != candidates.end() && of_point->first < pair.point) ++of_point;
    if (pair.kind != FeatureKind::face || of_point == candidates.end()) continue;
    const Vector3<double> p = points[pair.point].position(x);
    const FacetFoot at = foot_on(surface, pair.feature, p, x);
    if (!(at.from_rim > 0.0)) continue;
    double total = shared[first].share = at.from_rim;
    for (auto other = of_point; other != candidates.end() && other->first == pair.point; ++other) {
      if (other->second == pair.feature || surface.triangles()[other->second].body != body_of(surface, pair)) continue;
      const FacetFoot rival = foot_on(surface, other->second, p, x);
      if (rival.side != pair.side || dot(rival.normal, at.normal) < least_cosine) continue;
      const double closeness = 1.0 - (rival.distance - at.distance) / (about_as_near * at.distance);
      if (!(closeness > 0.0) || !(rival.from_rim > 0.0)) continue;
      PointPair with = pair;
      with.feature = other->second;
      shared.push_back({with, rival.from_rim * closeness});
      total += shared.back().share;
    }
    for (std::size_t n = first; n < shared.size(); ++n) shared[n].share /= total;
  }
  return shared;
}

}  // namespace pliant
