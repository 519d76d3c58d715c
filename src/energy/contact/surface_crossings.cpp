#include "energy/contact/surface_crossings.hpp"

#include "collision/box.hpp"
#include "collision/intersection.hpp"

namespace pliant {
namespace {

Box box_around(const CollisionSurface::Triangle& triangle, std::span<const Vector3<double>> x) {
  const auto [a, b, c] = triangle.vertices;
  return box_of(0.0, x[a], x[b], x[c]);
}

}  // namespace

SurfaceCrossings find_crossings(const BodySurfaces& surfaces, const NearPatches& near,
                                std::span<const Vector3<double>> x) {
  const CollisionSurface& surface = surfaces.surface();
  SurfaceCrossings crossings;
  const auto look_at = [&](std::size_t of_edges, std::size_t number) {
    const auto &one = surface.triangles()[of_edges], &other = surface.triangles()[number];
    if (other.is_segment()) return;
    for (int k = 0; k < static_cast<int>(one.sides().size()); ++k) {
      const auto& ends = surface.edges()[one.edges[k]].vertices;
      const bool touches = surface.is_incident(other, ends[0]) || surface.is_incident(other, ends[1]);
      if (!surfaces.stands_for_edge(of_edges, k) || touches) continue;
      const std::array segment{x[ends[0]], x[ends[1]]};
      const auto [a, b, c] = other.vertices;
      if (!segment_meets_triangle(segment, {x[a], x[b], x[c]})) continue;
      if (crossings.count++ == 0) {
        crossings.place = 0.5 * (segment[0] + segment[1]);
        crossings.body = one.body;
        crossings.other = other.body;
      }
    }
  };
  for (const PatchPair& pair : near.pairs) {
    const auto first = static_cast<std::size_t>(near.patches.keys[pair.first]);
    const auto second = static_cast<std::size_t>(near.patches.keys[pair.second]);
    if (!box_around(surface.triangles()[first], x).overlaps(box_around(surface.triangles()[second], x))) continue;
    look_at(first, second);
    look_at(second, first);
  }
  return crossings;
}

}  // namespace pliant
