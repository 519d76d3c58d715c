#include "energy/contact/touching_bodies.hpp"

#include "collision/candidates.hpp"
#include "collision/ccd.hpp"
#include "collision/closest_points.hpp"
#include "collision/shared_pairs.hpp"
#include "collision/vertex_pressures.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Share of the edge-edge part in the potential: small, because it is added to a pressure that is already complete.
constexpr double edge_share = 0.05;
/// Part of a gap that a step leaves at the least.
constexpr double kept_gap = 0.1;

/// Whether two places of one body at these squared distances now and at rest are only neighbours, not nearer to each
/// other than the body's deformation makes them: their gap says nothing.
bool is_neighbour(double square, double square_at_rest) {
  return square > 0.25 * square_at_rest;
}

template <class Item>
void make_unique(std::vector<Item>& items) {
  std::ranges::sort(items);
  items.erase(std::ranges::unique(items).begin(), items.end());
}

}  // namespace

TouchingBodies::TouchingBodies(std::shared_ptr<const BodySurfaces> surfaces, ContactSets sets, BodyContactLaws laws,
                               std::optional<FrictionUpdate> drag, PenaltyParts penalty)
    : surfaces_(std::move(surfaces)),
      sets_(std::move(sets)),
      laws_(std::move(laws)),
      drag_(drag),
      penalty_(std::move(penalty)) {
  edge_laws_ = laws_;
  for (NormalLaw& law : edge_laws_.of_bodies) law.kind = NormalKind::edge_barrier;
  const CollisionSurface& surface = surfaces_->surface();
  const ContactRule rule = quadratic_contact_rule();
  neighbours_ = SurfaceNeighbours(surface, laws_.num_bodies, laws_.neighbour_distances);
  multiplicities_ = FeatureMultiplicities(surface, sets_);
  sets_ = without(std::move(sets_), penalty_.is_mirror);
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

std::shared_ptr<const PairFeatures> TouchingBodies::features_of(const NearPatches& near) const {
  const CollisionSurface& surface = surfaces_->surface();
  const auto triangles = surface.triangles();
  auto features = std::make_shared<Features>();
  features->nodes.assign(surface.vertices().size(), -1);
  const auto number = [](std::size_t n) { return static_cast<std::int32_t>(n); };
  for (std::size_t patch = 0; patch < near.patches.size(); ++patch) {
    const auto triangle = static_cast<std::size_t>(near.patches.keys[patch]);
    const auto nodes = near.patches.nodes_of(patch);
    const auto vertices = surfaces_->nodes_of(triangle);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      features->nodes[vertices[k]] = nodes[k];
      features->vertices.push_back(vertices[k]);
    }
    features->placed.insert(features->placed.end(), vertices.begin(), vertices.begin() + 3);
    features->triangles.push_back(number(triangle));
  }
  for (auto* numbers : {&features->vertices, &features->placed, &features->triangles}) make_unique(*numbers);
  const std::size_t first_inner_point = points_.size() - num_inner_points_ * triangles.size();
  auto& [points, edges] = features->candidates;
  // The points that the first triangle stands for, with the second.
  const auto add_points = [&](std::size_t first, std::size_t second, bool is_incident) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = triangles[first].vertices[k];
      if (surfaces_->stands_for_vertex(first, k) && !surface.is_incident(triangles[second], vertex) &&
          !neighbours_.include(std::array{vertex}, triangles[second].vertices)) {
        points.push_back({point_of_corner_[3 * first + static_cast<std::size_t>(k)], number(second)});
      }
    }
    const bool are_near = is_incident || neighbours_.include(triangles[first].vertices, triangles[second].vertices);
    for (std::size_t j = 0; !are_near && j < num_inner_points_; ++j) {
      points.push_back({number(first_inner_point + num_inner_points_ * first + j), number(second)});
    }
  };
  for (const PatchPair& pair : near.pairs) {
    if (is_penalty()) break;  // these are not all that it needs
    const auto first = static_cast<std::size_t>(near.patches.keys[pair.first]);
    const auto second = static_cast<std::size_t>(near.patches.keys[pair.second]);
    const auto &a = triangles[first], &b = triangles[second];
    const bool is_incident = surface.is_incident(a, b);
    add_points(first, second, is_incident);
    add_points(second, first, is_incident);
    for (int k = 0; k < 3; ++k) {
      if (!surfaces_->stands_for_edge(first, k)) continue;
      for (int l = 0; l < 3; ++l) {
        if (!surfaces_->stands_for_edge(second, l)) continue;
        const auto [low, high] = std::minmax(a.edges[k], b.edges[l]);
        const auto &one = surface.edges()[low], &other = surface.edges()[high];
        if (!surface.is_incident(one, other) && !neighbours_.include(one.vertices, other.vertices)) {
          edges.push_back({low, high});
        }
      }
    }
  }
  // One triangle stands for each vertex and edge, so each pair is there once.
  sort_pairs(points, points_.size());
  sort_pairs(edges, surface.edges().size());
  return features;
}

TouchingBodies::Positions TouchingBodies::positions(const NearPatches& near, std::span<const double> q,
                                                    std::span<const double> d) const {
  const Features& known = features(near);
  Positions at;
  at.x.resize(known.nodes.size());
  if (!d.empty()) at.dx.resize(known.nodes.size());
  for (const std::int32_t v : known.vertices) {
    const PetscInt node = known.nodes[v];
    const auto i = 3 * static_cast<std::size_t>(node);
    at.x[v] = near.position(node, q);
    if (!d.empty()) at.dx[v] = {d[i], d[i + 1], d[i + 2]};
  }
  surfaces_->place(known.placed, at.x);
  if (!d.empty()) surfaces_->place(known.placed, at.dx);
  return at;
}

TouchingBodies::Candidates TouchingBodies::candidates(const NearPatches& near, const Positions& at,
                                                      double distance) const {
  if (is_penalty()) return known_candidates(near, at, distance);
  const CollisionSurface& surface = surfaces_->surface();
  const auto box = [&](double margin, const auto&... vertices) {
    Box around = box_of(margin, at.x[vertices]...);
    if (!at.dx.empty()) around.include(box_of(margin, (at.x[vertices] + at.dx[vertices])...));
    return around;
  };
  const auto& [points, edges] = features(near).candidates;
  std::vector<Box> of_triangles(surface.triangles().size()), of_edges(surface.edges().size());
  for (const std::int32_t triangle : features(near).triangles) {
    const auto& [a, b, c] = surface.triangles()[triangle].vertices;
    of_triangles[triangle] = box(distance, a, b, c);
    for (const std::int32_t edge : surface.triangles()[triangle].edges) {
      const auto& [from, to] = surface.edges()[edge].vertices;
      of_edges[edge] = box(0.5 * distance, from, to);
    }
  }
  Candidates found;
  std::int32_t last = -1;
  Box of_point;
  for (const BoxPair& pair : points) {
    if (pair.first != last) {
      last = pair.first;
      const SurfacePoint& point = points_[last];
      of_point = box_of(0.0, point.position(at.x));
      if (!at.dx.empty()) of_point.include(box_of(0.0, point.position(at.x) + point.position(at.dx)));
    }
    if (of_point.overlaps(of_triangles[pair.second])) found.points.push_back(pair);
  }
  for (const BoxPair& pair : edges) {
    if (of_edges[pair.first].overlaps(of_edges[pair.second])) found.edges.push_back(pair);
  }
  return found;
}

TouchingBodies::Configuration& TouchingBodies::configuration(const NearPatches& near, std::span<const double> q) const {
  Positions at = positions(near, q);
  for (Configuration& known : last_) {
    if (known.features == near.features && known.x == at.x) return known;
  }
  Configuration& now = last_[std::exchange(oldest_, (oldest_ + 1) % last_.size())];
  Candidates found = candidates(near, at, std::max(laws_.reach(), range()));
  now.features = near.features;
  now.pairs = {point_pairs_of(found, at.x), edge_pairs_of(found, at.x)};
  if (is_penalty()) now.near_points = std::move(found.points);
  now.x = std::move(at.x);
  now.touches.reset();
  return now;
}

std::vector<PointPair> TouchingBodies::point_pairs_of(const Candidates& found,
                                                      std::span<const Vector3<double>> x) const {
  const CollisionSurface& surface = surfaces_->surface();
  if (is_penalty())
    return nearest_pairs(surface, multiplicities_, points_, found.points, x, laws_.reach(), penalty_.depth);
  auto pairs = point_pairs(surface, multiplicities_, points_, found.points, x, laws_.reach());
  if (laws_.keep_one_distance()) return pairs;
  std::erase_if(pairs, [&](const PointPair& pair) {
    const PairGeometry at = geometry_of(surface, points_, pair, x);
    return at.distance >= laws_.of(at.body, at.other).reach();
  });
  return pairs;
}

std::vector<EdgePair> TouchingBodies::edge_pairs_of(const Candidates& found, std::span<const Vector3<double>> x) const {
  const CollisionSurface& surface = surfaces_->surface();
  auto pairs = edge_pairs(surface, found.edges, x, laws_.reach(), edge_share);
  if (laws_.keep_one_distance()) return pairs;
  std::erase_if(pairs, [&](const EdgePair& pair) {
    const auto &a = surface.edges()[pair.a], &b = surface.edges()[pair.b];
    const std::array ends{x[a.vertices[0]], x[a.vertices[1]], x[b.vertices[0]], x[b.vertices[1]]};
    const double reach = laws_.of(a.body, b.body).reach();
    return closest_edge_edge(ends).squared_distance >= reach * reach;
  });
  return pairs;
}

const std::vector<Touch>& TouchingBodies::touches(const NearPatches& near, std::span<const double> q) const {
  Configuration& now = configuration(near, q);
  if (now.touches) return *now.touches;
  const CollisionSurface& surface = surfaces_->surface();
  const auto& nodes = features(near).nodes;
  std::vector<Touch>& touches = now.touches.emplace();
  const auto add = [&](const PairGeometry& pair, const BodyContactLaws& laws, double share) {
    Touch touch{.pressure = laws(pair.body, pair.other, pair.distance).pressure,
                .area = share * pair.weight,
                .normal = pair.normal,
                .is_counted = near.is_owned(nodes[pair.first_vertex])};
    if (touch.area == 0.0 || !(touch.pressure > 0.0)) return;
    int begin = 0;  // of the nodes of the present surface
    for (int i = 0; i < pair.num_nodes; ++i) {
      if (i == pair.num_first_nodes) begin = touch.num_first_nodes = touch.num_nodes;
      const auto of_vertex = surfaces_->support(pair.nodes[i]);
      for (int a = 0; a < of_vertex.size; ++a) {
        touch.add(nodes[of_vertex.nodes[a]], of_vertex.weights[a] * pair.weights[i], begin);
      }
    }
    const auto used = std::span(touch.nodes).first(static_cast<std::size_t>(touch.num_nodes));
    if (std::ranges::any_of(used, [&](PetscInt node) { return near.is_owned(node); })) touches.push_back(touch);
  };
  for (const auto& [pair, share] : shared_pairs(surface, points_, now.pairs.points, now.near_points, now.x))
    add(geometry_of(surface, points_, pair, now.x), laws_, share);
  for (const EdgePair& pair : now.pairs.edges) add(geometry_of(surface, pair, now.x), edge_laws_, 1.0);
  return touches;
}

std::span<const double> TouchingBodies::frozen_place(const LocalStage& stage, std::span<const double> q) const {
  if (!drag_) return {};
  return stage.frozen_at(*drag_ == FrictionUpdate::iterated, q);
}

double TouchingBodies::energy(const NearPatches& near, std::span<const double> q) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Configuration& now = configuration(near, q);
  const auto is_counted_elsewhere = [&](std::int32_t vertex) { return !near.is_owned(features(near).nodes[vertex]); };
  ContactPairs pairs = now.pairs;
  std::erase_if(pairs.points, [&](const PointPair& pair) { return is_counted_elsewhere(first_vertex(surface, pair)); });
  std::erase_if(pairs.edges,
                [&](const EdgePair& pair) { return is_counted_elsewhere(surface.edges()[pair.a].vertices[0]); });
  const auto nothing = [](auto...) {};
  return add_point_pairs(surface, points_, pairs.points, now.x, laws_, ContactOrder::gradient, nothing, nothing) +
         add_edge_pairs(surface, pairs.edges, now.x, edge_laws_, ContactOrder::gradient, nothing, nothing);
}

std::vector<double> TouchingBodies::pressures(const NearPatches& near, std::span<const double> q) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Configuration& now = configuration(near, q);
  std::vector<Vector3<double>> slopes(surface.vertices().size());  // of the potential, against the forces
  const auto add = [&](std::int32_t vertex, const Vector3<double>& f) { slopes[vertex] = slopes[vertex] + f; };
  const auto nothing = [](auto...) {};
  add_point_pairs(surface, points_, now.pairs.points, now.x, laws_, ContactOrder::gradient, add, nothing);
  add_edge_pairs(surface, now.pairs.edges, now.x, edge_laws_, ContactOrder::gradient, add, nothing);
  const std::vector<double> of_vertices = vertex_pressures(surface, features(near).triangles, now.x, slopes);
  std::vector<double> pressures(static_cast<std::size_t>(near.num_owned_nodes), 0.0);
  for (const std::int32_t vertex : features(near).placed) {
    const PetscInt node = features(near).nodes[vertex];
    if (near.is_owned(node)) pressures[node] = of_vertices[vertex];
  }
  return pressures;
}

double TouchingBodies::max_step(const NearPatches& near, std::span<const double> q, std::span<const double> d) const {
  if (is_penalty() && (penalty_.limits_steps == nullptr || !*penalty_.limits_steps))
    return std::numeric_limits<double>::infinity();
  const Positions at = positions(near, q, d);
  if (is_penalty()) return max_step_of_penalty(near, at);
  const CollisionSurface& surface = surfaces_->surface();
  const Candidates found = candidates(near, at, laws_.reach());
  double bound = 1.0;
  const auto limit_by = [&](const auto& max_step, const std::array<std::int32_t, 4>& v, int body, int other) {
    std::array<Vector3<double>, 4> x, dx;
    for (std::size_t i = 0; i < 4; ++i) {
      x[i] = at.x[v[i]];
      dx[i] = at.dx[v[i]];
    }
    bound = std::min(bound, max_step(x, dx, Clearance{laws_.of(body, other).threshold, kept_gap}));
  };
  for (const BoxPair& pair : found.points) {
    const SurfacePoint& point = points_[pair.first];
    if (point.num_nodes > 1) continue;  // inside a triangle
    const auto& triangle = surface.triangles()[pair.second];
    if (triangle.is_segment()) continue;  // a point is on edges, which do not meet the segment's
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
  const Positions at = positions(near, q);
  double threshold = 0.0;
  for (const NormalLaw& law : laws_.of_bodies) threshold = std::max(threshold, law.threshold);
  ContactGap gap;
  std::int32_t last = -1;
  double within = std::max(laws_.reach(), range());
  Candidates found = candidates(near, at, within);
  for (const PointPair& pair : point_pairs_of(found, at.x)) {
    const bool is_counted = near.is_owned(features(near).nodes[points_[pair.point].nodes[0]]);
    if (is_counted && pair.point != last) gap.num_points += 1.0;
    last = pair.point;
  }
  gap.least = least_gap(near, at, found);
  // What was not found is farther away.
  while (!(gap.least <= within - threshold) && within < distance) {
    within = std::min(4.0 * within, distance);
    found = candidates(near, at, within);
    gap.least = least_gap(near, at, found);
  }
  return gap;
}

double TouchingBodies::least_gap(const NearPatches& near, const Positions& at, const Candidates& found) const {
  const CollisionSurface& surface = surfaces_->surface();
  double least = std::numeric_limits<double>::infinity();
  if (is_penalty()) {
    for_each_gap(near, at, found, std::numeric_limits<double>::infinity(),
                 [&](const SurfacePoint&, double gap) { least = std::min(least, gap); });
    return least;
  }
  const auto include = [&](const auto& square_at, int body, int other) {
    const double square = square_at(std::span<const Vector3<double>>(at.x));
    if (body == other && is_neighbour(square, square_at(surface.rest_positions()))) return;
    least = std::min(least, std::sqrt(square) - laws_.of(body, other).threshold);
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
  return least;
}

template <class Visit>
void TouchingBodies::for_each_gap(const NearPatches& near, const Positions& at, const Candidates& found,
                                  double distance, const Visit& visit) const {
  const CollisionSurface& surface = surfaces_->surface();
  for (const PointPair& pair :
       nearest_pairs(surface, multiplicities_, points_, found.points, at.x, distance, penalty_.depth)) {
    const SurfacePoint& point = points_[pair.point];
    // On other ranks something nearer may be unknown.
    if (!near.is_owned(features(near).nodes[point.nodes[0]])) continue;
    const PairGeometry geometry = geometry_of(surface, points_, pair, at.x);
    visit(point, geometry.distance - laws_.of(geometry.body, geometry.other).threshold);
  }
}

void TouchingBodies::lower_gaps(const NearPatches& near, std::span<const double> q, double distance,
                                std::span<double> gaps) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Positions at = positions(near, q);
  const Candidates found = candidates(near, at, distance);
  if (is_penalty()) {
    for_each_gap(near, at, found, distance, [&](const SurfacePoint& point, double gap) {
      const PetscInt node = features(near).nodes[point.nodes[0]];
      if (point.num_nodes == 1) gaps[node] = std::min(gaps[node], gap);
    });
    return;
  }
  for (const BoxPair& pair : found.points) {
    const SurfacePoint& point = points_[pair.first];
    const PetscInt node = features(near).nodes[point.nodes[0]];
    if (point.num_nodes > 1 || !near.is_owned(node)) continue;
    const auto& triangle = surface.triangles()[pair.second];
    const auto [a, b, c] = triangle.vertices;
    const auto square_at = [&](std::span<const Vector3<double>> x) {
      return closest_point_triangle(std::array{point.position(x), x[a], x[b], x[c]}).squared_distance;
    };
    const std::int32_t body = surface.vertices()[point.nodes[0]].body;
    const double square = square_at(at.x);
    if (body == triangle.body && is_neighbour(square, square_at(surface.rest_positions()))) continue;
    gaps[node] = std::min(gaps[node], std::sqrt(square) - laws_.of(body, triangle.body).threshold);
  }
}

SurfaceCrossings TouchingBodies::crossings(const NearPatches& near, std::span<const double> q) const {
  return is_penalty() ? SurfaceCrossings{} : find_crossings(*surfaces_, near, positions(near, q).x);
}

}  // namespace pliant
