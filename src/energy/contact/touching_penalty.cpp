// What a penalty needs of the surfaces of bodies: all triangles near a point, whatever touches, and steps that stay
// where it pushes.
#include "collision/candidates.hpp"
#include "collision/ccd.hpp"
#include "energy/contact/touching_bodies.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// How deep a step may take a point, as a part of the depth to which the penalty pushes; how far one that is deeper
/// already may still go.
constexpr double deep_enough = 0.5, little = 0.05;
/// Long ways are taken piece by piece, since boxes around them overlap nearly everything: the length of a piece in
/// these depths, and the most of them.
constexpr double depths_of_piece = 8.0;
constexpr int most_pieces = 32;

}  // namespace

TouchingBodies::Candidates TouchingBodies::known_candidates(const NearPatches& near, const Positions& at,
                                                            double distance) const {
  const CollisionSurface& surface = surfaces_->surface();
  const std::size_t first_inner_point = points_.size() - num_inner_points_ * surface.triangles().size();
  Candidates found;
  const auto add_points = [&](std::int32_t of_points, std::int32_t t) {
    const auto &mine = surface.triangles()[of_points], &theirs = surface.triangles()[t];
    if (!penalty_.has_points.empty() && penalty_.has_points[mine.group] == 0) return;
    const auto first = static_cast<std::size_t>(of_points);
    const auto [a, b, c] = theirs.vertices;
    Box around = box_of(distance, at.x[a], at.x[b], at.x[c]);
    if (!at.dx.empty()) around.include(box_of(distance, at.x[a] + at.dx[a], at.x[b] + at.dx[b], at.x[c] + at.dx[c]));
    const auto add = [&](std::size_t point) {
      const Vector3<double> p = points_[point].position(at.x);
      Box of_point = box_of(0.0, p);
      if (!at.dx.empty()) of_point.include(box_of(0.0, p + points_[point].position(at.dx)));
      if (of_point.overlaps(around)) found.points.push_back({static_cast<std::int32_t>(point), t});
    };
    for (std::size_t k = 0; k < 3; ++k) {
      if (!surface.is_incident(theirs, mine.vertices[k]))
        add(static_cast<std::size_t>(point_of_corner_[3 * first + k]));
    }
    for (std::size_t j = 0; j < num_inner_points_ && !surface.is_incident(mine, theirs); ++j) {
      add(first_inner_point + num_inner_points_ * first + j);
    }
  };
  for (const BoxPair& pair : triangles_of_bodies_near(surface, at.x, at.dx, features(near).triangles, distance)) {
    if (!sets_(surface.triangles()[pair.first].group, surface.triangles()[pair.second].group)) continue;
    add_points(pair.first, pair.second);
    add_points(pair.second, pair.first);
  }
  sort_pairs(found.points, points_.size());
  found.points.erase(std::ranges::unique(found.points).begin(), found.points.end());
  return found;
}

double TouchingBodies::max_step_of_penalty(const NearPatches& near, Positions at) const {
  double farthest = 0.0;
  for (const std::int32_t v : features(near).placed) farthest = std::max(farthest, norm(at.dx[v]));
  if (2.0 * farthest <= little * penalty_.depth) return std::numeric_limits<double>::infinity();
  const double size = std::min(1.0, depths_of_piece * penalty_.depth / farthest);
  for (const std::int32_t v : features(near).vertices) at.dx[v] = size * at.dx[v];
  double from = 0.0;
  for (int piece = 0; piece < most_pieces && from < 1.0; ++piece, from += size) {
    const double bound = step_to_depth(near, at);
    if (bound < 1.0) return std::min(1.0, from + bound * size);
    for (const std::int32_t v : features(near).vertices) at.x[v] = at.x[v] + at.dx[v];
  }
  return from < 1.0 ? from : std::numeric_limits<double>::infinity();
}

double TouchingBodies::step_to_depth(const NearPatches& near, const Positions& at) const {
  const CollisionSurface& surface = surfaces_->surface();
  const double depth = deep_enough * penalty_.depth;
  const Candidates found = candidates(near, at, std::max(laws_.reach(), range()));
  // On other ranks something nearer may be unknown.
  const auto is_counted = [&](std::int32_t point) {
    return near.is_owned(features(near).nodes[points_[static_cast<std::size_t>(point)].nodes[0]]);
  };
  double bound = 1.0;
  // Those that are behind a surface already.
  std::vector<char> is_behind(points_.size(), 0);
  for (const PointPair& pair :
       nearest_pairs(surface, multiplicities_, points_, found.points, at.x, laws_.reach(), penalty_.depth)) {
    if (!is_counted(pair.point)) continue;
    const PairGeometry geometry = geometry_of(surface, points_, pair, at.x);
    const double gap = geometry.distance - laws_.of(geometry.body, geometry.other).threshold;
    if (gap > 0.0) continue;
    is_behind[static_cast<std::size_t>(pair.point)] = 1;
    Vector3<double> d{};
    for (int i = 0; i < geometry.num_nodes; ++i) d = d + geometry.weights[i] * at.dx[geometry.nodes[i]];
    const double approach = -dot(geometry.normal, d);
    if (approach > 0.0) bound = std::min(bound, std::max(depth + gap, little * penalty_.depth) / approach);
  }
  for (const BoxPair& pair : found.points) {
    const auto& triangle = surface.triangles()[pair.second];
    if (!is_counted(pair.first) || is_behind[static_cast<std::size_t>(pair.first)] != 0 || triangle.is_segment())
      continue;
    const SurfacePoint& point = points_[pair.first];
    const auto [a, b, c] = triangle.vertices;
    const std::array x{point.position(at.x), at.x[a], at.x[b], at.x[c]},
        dx{point.position(at.dx), at.dx[a], at.dx[b], at.dx[c]};
    const double threshold = laws_.of(surface.vertices()[point.nodes[0]].body, triangle.body).threshold;
    bound = std::min(bound, max_step_into_triangle(x, dx, threshold, depth));
  }
  return bound;
}

}  // namespace pliant
