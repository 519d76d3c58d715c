#include "collision/candidates.hpp"

#include "collision/closest_points.hpp"
#include "collision/intersection.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace pliant {

void BroadPhase::set_boxes(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                           std::span<const Vector3<double>> y, double distance) {
  // Half of the distance around either part.
  const double margin = 0.5 * distance;
  const auto vertices = surface.vertices();
  vertex_boxes_.resize(vertices.size());
  for (std::size_t n = 0; n < vertices.size(); ++n) vertex_boxes_[n] = box_of(margin, x[n], y[n]);
  const auto united = [&](const auto& numbers) {
    Box box;
    for (const std::int32_t n : numbers) box.include(vertex_boxes_[n]);
    return box;
  };
  const auto edges = surface.edges();
  edge_boxes_.resize(edges.size());
  for (std::size_t n = 0; n < edges.size(); ++n) edge_boxes_[n] = united(edges[n].vertices);
  const auto triangles = surface.triangles();
  triangle_boxes_.resize(triangles.size());
  for (std::size_t n = 0; n < triangles.size(); ++n) triangle_boxes_[n] = united(triangles[n].vertices);
}

BroadPhase::BroadPhase(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                       std::span<const Vector3<double>> y, double distance) {
  set_boxes(surface, x, y, distance);
  vertices_ = Bvh(vertex_boxes_);
  edges_ = Bvh(edge_boxes_);
  triangles_ = Bvh(triangle_boxes_);
}

void BroadPhase::refit(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                       std::span<const Vector3<double>> y, double distance) {
  set_boxes(surface, x, y, distance);
  vertices_.refit(vertex_boxes_);
  edges_.refit(edge_boxes_);
  triangles_.refit(triangle_boxes_);
}

Candidates BroadPhase::candidates(const CollisionSurface& surface) const {
  const auto edges = surface.edges();
  const auto triangles = surface.triangles();
  return {overlapping_pairs(vertices_, triangles_,
                            [&](std::int32_t vertex, std::int32_t triangle) {
                              return !surface.is_incident(triangles[triangle], vertex);
                            }),
          overlapping_pairs(edges_, [&](std::int32_t edge, std::int32_t other) {
            return !surface.is_incident(edges[edge], edges[other]);
          })};
}

Candidates find_candidates(const CollisionSurface& surface, std::span<const Vector3<double>> x, double distance) {
  return BroadPhase(surface, x, x, distance).candidates(surface);
}

std::vector<double> least_distances(const CollisionSurface& surface, std::span<const Vector3<double>> x, int num_bodies,
                                    double distance, const SurfaceNeighbours& neighbours) {
  const auto n = static_cast<std::size_t>(num_bodies);
  std::vector<double> squares(n * n, distance * distance);
  const auto lower = [&](int body, int other, double square) {
    for (double* entry : {&squares[n * body + other], &squares[n * other + body]}) *entry = std::min(*entry, square);
  };
  const Candidates candidates = find_candidates(surface, x, distance);
  for (const BoxPair& pair : candidates.point_triangle) {
    const auto& triangle = surface.triangles()[pair.second];
    const auto [a, b, c] = triangle.vertices;
    if (neighbours.include(std::array{pair.first}, triangle.vertices)) continue;
    lower(surface.vertices()[pair.first].body, triangle.body,
          closest_point_triangle(std::array{x[pair.first], x[a], x[b], x[c]}).squared_distance);
  }
  for (const BoxPair& pair : candidates.edge_edge) {
    const auto &a = surface.edges()[pair.first], &b = surface.edges()[pair.second];
    if (neighbours.include(a.vertices, b.vertices)) continue;
    const std::array ends{x[a.vertices[0]], x[a.vertices[1]], x[b.vertices[0]], x[b.vertices[1]]};
    lower(a.body, b.body, closest_edge_edge(ends).squared_distance);
  }
  for (double& entry : squares) entry = std::sqrt(entry);
  return squares;
}

std::vector<BoxPair> triangles_of_bodies_near(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                                              std::span<const Vector3<double>> dx,
                                              std::span<const std::int32_t> numbers, double distance) {
  const auto triangles = surface.triangles();
  const auto box = [&](std::int32_t t) {
    const auto [a, b, c] = triangles[t].vertices;
    Box around = box_of(0.5 * distance, x[a], x[b], x[c]);
    if (!dx.empty()) around.include(box_of(0.5 * distance, x[a] + dx[a], x[b] + dx[b], x[c] + dx[c]));
    return around;
  };
  std::map<std::int32_t, Box> of_bodies;
  for (const std::int32_t t : numbers) of_bodies[triangles[t].body].include(box(t));
  std::vector<std::int32_t> near;  // another body's box
  std::vector<Box> boxes;
  for (const std::int32_t t : numbers) {
    const Box mine = box(t);
    const bool is_near = std::ranges::any_of(of_bodies, [&](const auto& of_body) {
      return of_body.first != triangles[t].body && mine.overlaps(of_body.second);
    });
    if (!is_near) continue;
    near.push_back(t);
    boxes.push_back(mine);
  }
  std::vector<BoxPair> pairs;
  if (near.empty()) return pairs;
  Bvh(boxes).for_each_overlap([&](std::int32_t i, std::int32_t j) {
    if (triangles[near[i]].body != triangles[near[j]].body) pairs.push_back({near[i], near[j]});
  });
  return pairs;
}

std::vector<BoxPair> find_intersections(const CollisionSurface& surface, std::span<const Vector3<double>> x) {
  std::vector<Box> boxes(surface.triangles().size()), edge_boxes(surface.edges().size());
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    const auto& t = surface.triangles()[n].vertices;
    boxes[n] = box_of(0.0, x[t[0]], x[t[1]], x[t[2]]);
  }
  for (std::size_t n = 0; n < edge_boxes.size(); ++n) {
    const auto& e = surface.edges()[n].vertices;
    edge_boxes[n] = box_of(0.0, x[e[0]], x[e[1]]);
  }
  return overlapping_pairs(Bvh(edge_boxes), Bvh(boxes), [&](std::int32_t edge, std::int32_t triangle) {
    const auto& e = surface.edges()[edge].vertices;
    const auto& t = surface.triangles()[triangle].vertices;
    const bool is_incident = surface.is_incident(surface.triangles()[triangle], e[0]) ||
                             surface.is_incident(surface.triangles()[triangle], e[1]);
    return !is_incident && !surface.triangles()[triangle].is_segment() &&
           segment_meets_triangle({x[e[0]], x[e[1]]}, {x[t[0]], x[t[1]], x[t[2]]});
  });
}

}  // namespace pliant
