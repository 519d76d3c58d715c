#include "energy/contact/touching_bodies.hpp"

#include "collision/ccd.hpp"
#include "collision/closest_points.hpp"
#include "collision/intersection.hpp"

#include <algorithm>
#include <stdexcept>

namespace pliant {
namespace {

/// Share of the edge-edge part in the potential: small, because it is added to a pressure that is already complete.
constexpr double edge_share = 0.05;
/// Part of a gap that a step leaves at the least.
constexpr double kept_gap = 0.1;

}  // namespace

double BodyContactLaws::reach() const {
  double reach = 0.0;
  for (const NormalLaw& law : of_bodies) reach = std::max(reach, law.reach());
  return reach;
}

Vector3<double> Touch::displacement(std::span<const double> from, std::span<const double> to) const {
  Vector3<double> total{};
  for (int i = 0; i < num_nodes; ++i) {
    const auto n = 3 * static_cast<std::size_t>(nodes[i]);
    for (std::size_t k = 0; k < 3; ++k) total[k] += weights[i] * (to[n + k] - from[n + k]);
  }
  return total;
}

Vector3<double> Touch::combine(std::span<const double> v) const {
  Vector3<double> total{};
  for (int i = 0; i < num_nodes; ++i) {
    const auto n = 3 * static_cast<std::size_t>(nodes[i]);
    for (std::size_t k = 0; k < 3; ++k) total[k] += weights[i] * v[n + k];
  }
  return total;
}

TouchingBodies::TouchingBodies(std::shared_ptr<const BodySurfaces> surfaces, ContactSets sets, BodyContactLaws laws,
                               std::optional<FrictionUpdate> drag)
    : surfaces_(std::move(surfaces)), sets_(std::move(sets)), laws_(std::move(laws)), drag_(drag) {
  for (const NormalLaw& law : laws_.of_bodies) {
    if (law.kind != NormalKind::barrier) throw std::invalid_argument("contact between bodies needs a barrier");
  }
  edge_laws_ = laws_;
  for (NormalLaw& law : edge_laws_.of_bodies) law.kind = NormalKind::edge_barrier;
  const CollisionSurface& surface = surfaces_->surface();
  const ContactRule rule = quadratic_contact_rule();
  multiplicities_ = FeatureMultiplicities(surface, sets_);
  points_ = surface_points(surface, rule);
  num_inner_points_ = rule.inner_points.size();
  const auto corners = std::span(points_).first(points_.size() - num_inner_points_ * surface.triangles().size());
  for (const auto& triangle : surface.triangles()) {
    for (const std::int32_t vertex : triangle.vertices) {
      const auto place = [](const SurfacePoint& point) { return std::pair(point.nodes[0], point.group); };
      const auto point = std::ranges::lower_bound(corners, std::pair(vertex, triangle.group), {}, place);
      point_of_corner_.push_back(static_cast<std::int32_t>(point - corners.begin()));
    }
  }
}

namespace {

/// The box around a triangle, on its way if it moves, `margin` [m] further out.
Box box_around(const CollisionSurface::Triangle& triangle, double margin, std::span<const Vector3<double>> x,
               std::span<const Vector3<double>> dx = {}) {
  const auto [a, b, c] = triangle.vertices;
  Box box = box_of(margin, x[a], x[b], x[c]);
  if (!dx.empty()) box.include(box_of(margin, x[a] + dx[a], x[b] + dx[b], x[c] + dx[c]));
  return box;
}

/// Whether two places of one body at these squared distances now and at rest are only neighbours, not nearer to each
/// other than the body's deformation makes them: their gap says nothing.
bool is_neighbour(double square, double square_at_rest) {
  return square > 0.25 * square_at_rest;
}

/// Sorted and once each.
void make_unique(std::vector<BoxPair>& pairs) {
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
}

}  // namespace

TouchingBodies::Near TouchingBodies::near_at(const NearPatches& near, double distance, std::span<const double> q,
                                             std::span<const double> d) const {
  const CollisionSurface& surface = surfaces_->surface();
  const auto triangles = surface.triangles();
  const std::size_t num_vertices = surface.vertices().size();
  Near found;
  found.x.resize(num_vertices);
  if (!d.empty()) found.dx.resize(num_vertices);
  found.nodes.assign(num_vertices, -1);
  for (std::size_t patch = 0; patch < near.patches.size(); ++patch) {
    const auto nodes = near.patches.nodes_of(patch);
    const auto& vertices = triangles[near.patches.keys[patch]].vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = vertices[k];
      const auto i = 3 * static_cast<std::size_t>(nodes[k]);
      found.nodes[v] = nodes[k];
      found.x[v] = near.position(nodes[k], q);
      if (!d.empty()) found.dx[v] = {d[i], d[i + 1], d[i + 2]};
    }
  }
  const std::size_t first_inner_point = points_.size() - num_inner_points_ * triangles.size();
  const auto number = [](std::size_t n) { return static_cast<std::int32_t>(n); };
  // The points that the first triangle stands for, with the second.
  const auto add_points = [&](std::size_t first, std::size_t second, bool is_incident) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = triangles[first].vertices[k];
      if (surfaces_->stands_for_vertex(first, k) && !surface.is_incident(triangles[second], vertex)) {
        found.points.push_back({point_of_corner_[3 * first + static_cast<std::size_t>(k)], number(second)});
      }
    }
    for (std::size_t j = 0; !is_incident && j < num_inner_points_; ++j) {
      found.points.push_back({number(first_inner_point + num_inner_points_ * first + j), number(second)});
    }
  };
  for (const PatchPair& pair : near.pairs) {
    const auto first = static_cast<std::size_t>(near.patches.keys[pair.first]);
    const auto second = static_cast<std::size_t>(near.patches.keys[pair.second]);
    const auto &a = triangles[first], &b = triangles[second];
    if (!box_around(a, distance, found.x, found.dx).overlaps(box_around(b, 0.0, found.x, found.dx))) continue;
    const bool is_incident = surface.is_incident(a, b);
    add_points(first, second, is_incident);
    add_points(second, first, is_incident);
    for (int k = 0; k < 3; ++k) {
      if (!surfaces_->stands_for_edge(first, k)) continue;
      for (int l = 0; l < 3; ++l) {
        if (!surfaces_->stands_for_edge(second, l)) continue;
        const auto [low, high] = std::minmax(a.edges[k], b.edges[l]);
        if (!surface.is_incident(surface.edges()[low], surface.edges()[high])) found.edges.push_back({low, high});
      }
    }
  }
  make_unique(found.points);
  make_unique(found.edges);
  return found;
}

std::span<const double> TouchingBodies::frozen_place(const LocalStage& stage, std::span<const double> q) const {
  if (!drag_) return {};
  return stage.frozen_at(*drag_ == FrictionUpdate::iterated, q);
}

ContactPairs TouchingBodies::pairs_of(const Near& near) const {
  const CollisionSurface& surface = surfaces_->surface();
  return {point_pairs(surface, multiplicities_, points_, near.points, near.x, laws_.reach()),
          edge_pairs(surface, near.edges, near.x, laws_.reach(), edge_share)};
}

double TouchingBodies::energy(const NearPatches& near, std::span<const double> q) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Near found = near_at(near, laws_.reach(), q);
  ContactPairs pairs = pairs_of(found);
  const auto is_counted_elsewhere = [&](std::int32_t vertex) { return !near.is_owned(found.nodes[vertex]); };
  std::erase_if(pairs.points, [&](const PointPair& pair) { return is_counted_elsewhere(first_vertex(surface, pair)); });
  std::erase_if(pairs.edges,
                [&](const EdgePair& pair) { return is_counted_elsewhere(surface.edges()[pair.a].vertices[0]); });
  const auto nothing = [](auto...) {};
  return add_point_pairs(surface, points_, pairs.points, found.x, laws_, ContactOrder::gradient, nothing, nothing) +
         add_edge_pairs(surface, pairs.edges, found.x, edge_laws_, ContactOrder::gradient, nothing, nothing);
}

double TouchingBodies::max_step(const NearPatches& near, std::span<const double> q, std::span<const double> d) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Near found = near_at(near, laws_.reach(), q, d);
  double bound = 1.0;
  const auto limit_by = [&](const auto& max_step, const std::array<std::int32_t, 4>& v, int body, int other) {
    std::array<Vector3<double>, 4> x, dx;
    for (std::size_t i = 0; i < 4; ++i) {
      x[i] = found.x[v[i]];
      dx[i] = found.dx[v[i]];
    }
    bound = std::min(bound, max_step(x, dx, Clearance{laws_.of(body, other).threshold, kept_gap}));
  };
  for (const BoxPair& pair : found.points) {
    const SurfacePoint& point = points_[pair.first];
    if (point.num_nodes > 1) continue;  // inside a triangle
    const auto& triangle = surface.triangles()[pair.second];
    const auto [a, b, c] = triangle.vertices;
    limit_by(max_step_point_triangle, {point.nodes[0], a, b, c}, surface.vertices()[point.nodes[0]].body,
             triangle.body);
  }
  for (const BoxPair& pair : found.edges) {
    const auto &a = surface.edges()[pair.first], &b = surface.edges()[pair.second];
    limit_by(max_step_edge_edge, {a.vertices[0], a.vertices[1], b.vertices[0], b.vertices[1]}, a.body, b.body);
  }
  // Never 0, which means that an obstacle has moved onto the state: between bodies, values do not show who is where.
  return bound < 1.0 ? std::max(bound, std::numeric_limits<double>::min()) : std::numeric_limits<double>::infinity();
}

ContactGap TouchingBodies::gap(const NearPatches& near, std::span<const double> q, double distance) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Near found = near_at(near, distance, q);
  ContactGap gap;
  const auto include = [&](const auto& square_at, int body, int other) {
    const double square = square_at(std::span<const Vector3<double>>(found.x));
    if (body == other && is_neighbour(square, square_at(surface.rest_positions()))) return;
    gap.least = std::min(gap.least, std::sqrt(square) - laws_.of(body, other).threshold);
  };
  for (const BoxPair& pair : found.points) {
    const SurfacePoint& point = points_[pair.first];
    const auto& triangle = surface.triangles()[pair.second];
    const auto [a, b, c] = triangle.vertices;
    const auto square_at = [&](std::span<const Vector3<double>> x) {
      return closest_point_triangle(std::array{point.position(x), x[a], x[b], x[c]}).squared_distance;
    };
    include(square_at, surface.vertices()[point.nodes[0]].body, triangle.body);
  }
  for (const BoxPair& pair : found.edges) {
    const auto &a = surface.edges()[pair.first], &b = surface.edges()[pair.second];
    const auto square_at = [&](std::span<const Vector3<double>> x) {
      const std::array ends{x[a.vertices[0]], x[a.vertices[1]], x[b.vertices[0]], x[b.vertices[1]]};
      return closest_edge_edge(ends).squared_distance;
    };
    include(square_at, a.body, b.body);
  }
  std::int32_t last = -1;
  for (const PointPair& pair : point_pairs(surface, multiplicities_, points_, found.points, found.x, laws_.reach())) {
    const bool is_counted = near.is_owned(found.nodes[points_[pair.point].nodes[0]]);
    if (is_counted && pair.point != last) gap.num_points += 1.0;
    last = pair.point;
  }
  return gap;
}

void TouchingBodies::lower_gaps(const NearPatches& near, std::span<const double> q, double distance,
                                std::span<double> gaps) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Near found = near_at(near, distance, q);
  for (const BoxPair& pair : found.points) {
    const SurfacePoint& point = points_[pair.first];
    const PetscInt node = found.nodes[point.nodes[0]];
    if (point.num_nodes > 1 || !near.is_owned(node)) continue;
    const auto& triangle = surface.triangles()[pair.second];
    const auto [a, b, c] = triangle.vertices;
    const auto square_at = [&](std::span<const Vector3<double>> x) {
      return closest_point_triangle(std::array{point.position(x), x[a], x[b], x[c]}).squared_distance;
    };
    const std::int32_t body = surface.vertices()[point.nodes[0]].body;
    const double square = square_at(found.x);
    if (body == triangle.body && is_neighbour(square, square_at(surface.rest_positions()))) continue;
    gaps[node] = std::min(gaps[node], std::sqrt(square) - laws_.of(body, triangle.body).threshold);
  }
}

SurfaceCrossings TouchingBodies::crossings(const NearPatches& near, std::span<const double> q) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Near found = near_at(near, 0.0, q);
  SurfaceCrossings crossings;
  const auto look_at = [&](std::size_t of_edges, std::size_t number) {
    const auto &one = surface.triangles()[of_edges], &other = surface.triangles()[number];
    for (int k = 0; k < 3; ++k) {
      const auto& ends = surface.edges()[one.edges[k]].vertices;
      const bool touches = surface.is_incident(other, ends[0]) || surface.is_incident(other, ends[1]);
      if (!surfaces_->stands_for_edge(of_edges, k) || touches) continue;
      const std::array segment{found.x[ends[0]], found.x[ends[1]]};
      const auto [a, b, c] = other.vertices;
      if (!segment_meets_triangle(segment, {found.x[a], found.x[b], found.x[c]})) continue;
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
    const auto &a = surface.triangles()[first], &b = surface.triangles()[second];
    if (!box_around(a, 0.0, found.x).overlaps(box_around(b, 0.0, found.x))) continue;
    look_at(first, second);
    look_at(second, first);
  }
  return crossings;
}

}  // namespace pliant
