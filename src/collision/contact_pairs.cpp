#include "collision/contact_pairs.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// What is counted for a point: a feature, and how often.
struct Count {
  FeatureKind kind;
  std::int32_t feature, number;
};

/// Adds up counts of one feature; leaves those that are not zero, sorted.
void merge(std::vector<Count>& counts) {
  const auto key = [](const Count& count) { return std::pair(count.feature, count.kind); };
  std::ranges::sort(counts, {}, key);
  std::size_t kept = 0;
  for (std::size_t n = 0; n < counts.size();) {
    Count sum = counts[n];
    for (++n; n < counts.size() && key(counts[n]) == key(sum); ++n) sum.number += counts[n].number;
    if (sum.number != 0) counts[kept++] = sum;
  }
  counts.resize(kept);
}

void remove_doubles(std::vector<std::int32_t>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::ranges::unique(numbers).begin(), numbers.end());
}

/// Counts for one point after another, in buffers that stay.
class FeatureCounter {
 public:
  FeatureCounter(const CollisionSurface& surface, const FeatureMultiplicities& multiplicities,
                 std::span<const Vector3<double>> x, double reach)
      : surface_(surface), multiplicities_(multiplicities), x_(x), reach2_(reach * reach) {}

  /// The features near a point at p of the given group.
  std::span<const Count> count(const Vector3<double>& p, std::int32_t group, std::span<const BoxPair> candidates) {
    counts_.clear();
    edges_.clear();
    vertices_.clear();
    for (const BoxPair& pair : candidates) add_triangle(p, pair.second);
    remove_doubles(edges_);
    remove_doubles(vertices_);
    for (const std::int32_t edge : edges_) subtract_edge(p, edge, multiplicities_.edge(group, edge));
    for (const std::int32_t vertex : vertices_) {
      const Vector3<double> r = p - x_[vertex];
      if (dot(r, r) < reach2_) counts_.push_back({FeatureKind::vertex, vertex, multiplicities_.vertex(group, vertex)});
    }
    merge(counts_);
    return counts_;
  }

 private:
  void add_triangle(const Vector3<double>& p, std::int32_t number) {
    const auto& triangle = surface_.triangles()[number];
    const auto& v = triangle.vertices;
    const PointTriangle closest = closest_point_triangle(std::array{p, x_[v[0]], x_[v[1]], x_[v[2]]});
    if (!(closest.squared_distance < reach2_)) return;
    const int feature = static_cast<int>(closest.feature);
    if (closest.feature == TriangleFeature::face) {
      counts_.push_back({FeatureKind::face, number, 1});
    } else if (closest.feature >= TriangleFeature::edge_01) {
      counts_.push_back({FeatureKind::edge, triangle.edges[feature - static_cast<int>(TriangleFeature::edge_01)], 1});
    } else {
      counts_.push_back({FeatureKind::vertex, v[feature], 1});
    }
    edges_.insert(edges_.end(), triangle.edges.begin(), triangle.edges.end());
    vertices_.insert(vertices_.end(), v.begin(), v.end());
  }

  void subtract_edge(const Vector3<double>& p, std::int32_t number, std::int32_t multiplicity) {
    const auto& edge = surface_.edges()[number];
    const PointEdge closest = closest_point_edge(std::array{p, x_[edge.vertices[0]], x_[edge.vertices[1]]});
    if (!(closest.squared_distance < reach2_)) return;
    if (closest.feature == EdgeFeature::inside) {
      counts_.push_back({FeatureKind::edge, number, -multiplicity});
    } else {
      const std::int32_t vertex = edge.vertices[static_cast<std::size_t>(closest.feature)];
      counts_.push_back({FeatureKind::vertex, vertex, -multiplicity});
    }
  }

  const CollisionSurface& surface_;
  const FeatureMultiplicities& multiplicities_;
  std::span<const Vector3<double>> x_;
  double reach2_;
  std::vector<Count> counts_;
  std::vector<std::int32_t> edges_, vertices_;
};

}  // namespace

ContactRule quadratic_contact_rule() {
  const double a = (1.0 + std::sqrt(8.0 / 17.0)) / 3.0, b = 0.5 * (1.0 - a), weight = 17.0 / 60.0;
  const auto line = lobatto_rule();
  ContactRule rule{
      1.0 / 20.0, {{{a, b, b}, weight}, {{b, a, b}, weight}, {{b, b, a}, weight}}, line.front().weight, {}};
  for (std::size_t k = 1; k + 1 < line.size(); ++k) {
    rule.points_of_segment.push_back({{1.0 - line[k].at, line[k].at, 0.0}, line[k].weight});
  }
  return rule;
}

std::array<LinePoint, 5> lobatto_rule() {
  const double c = 0.5 * (1.0 - std::sqrt(3.0 / 7.0));
  return {{{0.0, 1.0 / 20.0}, {c, 49.0 / 180.0}, {0.5, 16.0 / 45.0}, {1.0 - c, 49.0 / 180.0}, {1.0, 1.0 / 20.0}}};
}

Vector3<double> SurfacePoint::position(std::span<const Vector3<double>> x) const {
  if (num_nodes == 1) return x[nodes[0]];
  if (num_nodes == 2) return weights[0] * x[nodes[0]] + weights[1] * x[nodes[1]];
  return weights[0] * x[nodes[0]] + weights[1] * x[nodes[1]] + weights[2] * x[nodes[2]];
}

ContactSets without(ContactSets sets, std::span<const char> left_out) {
  const auto n = static_cast<std::size_t>(sets.num_sets);
  for (std::size_t pair = 0; !left_out.empty() && pair < n * n; ++pair) {
    if (left_out[pair / n] != 0 || left_out[pair % n] != 0) sets.may_touch[pair] = 0;
  }
  return sets;
}

FeatureMultiplicities::FeatureMultiplicities(const CollisionSurface& surface, const ContactSets& sets)
    : num_edges_(surface.edges().size()), num_vertices_(surface.vertices().size()) {
  const auto num_sets = static_cast<std::size_t>(sets.num_sets);
  edges_.assign(num_sets * num_edges_, -1);
  vertices_.assign(num_sets * num_vertices_, 1);
  for (std::size_t set = 0; set < num_sets; ++set) {
    const auto of_edge = std::span(edges_).subspan(set * num_edges_, num_edges_);
    const auto of_vertex = std::span(vertices_).subspan(set * num_vertices_, num_vertices_);
    for (const auto& triangle : surface.triangles()) {
      if (!sets(static_cast<int>(set), triangle.group)) continue;
      for (const std::int32_t edge : triangle.sides()) ++of_edge[edge];
      for (const std::int32_t vertex : triangle.corners()) --of_vertex[vertex];
    }
    for (std::size_t edge = 0; edge < num_edges_; ++edge) {
      if (of_edge[edge] < 0) continue;  // no triangle is seen here
      for (const std::int32_t vertex : surface.edges()[edge].vertices) of_vertex[vertex] += of_edge[edge];
    }
  }
}

std::vector<SurfacePoint> surface_points(const CollisionSurface& surface, const ContactRule& rule) {
  std::vector<SurfacePoint> points;
  if (rule.corner_weight > 0.0) {
    for (const auto& triangle : surface.triangles()) {
      const double weight = triangle.is_segment() ? rule.end_weight : rule.corner_weight;
      for (const std::int32_t vertex : triangle.corners()) {
        points.push_back({{vertex}, {1.0}, 1, triangle.group, weight * triangle.area});
      }
    }
    const auto place = [](const SurfacePoint& point) { return std::pair(point.nodes[0], point.group); };
    std::ranges::stable_sort(points, {}, place);
    std::size_t kept = 0;
    for (std::size_t n = 0; n < points.size();) {
      SurfacePoint sum = points[n];
      for (++n; n < points.size() && place(points[n]) == place(sum); ++n) sum.area += points[n].area;
      points[kept++] = sum;
    }
    points.resize(kept);
  }
  for (const auto& triangle : surface.triangles()) {
    const auto num_nodes = static_cast<int>(triangle.corners().size());
    for (const RulePoint& inner : triangle.is_segment() ? rule.points_of_segment : rule.inner_points) {
      points.push_back({triangle.vertices, inner.barycentric, num_nodes, triangle.group, inner.weight * triangle.area});
    }
  }
  return points;
}

std::vector<BoxPair> point_candidates(const CollisionSurface& surface, std::span<const SurfacePoint> points,
                                      std::span<const Vector3<double>> x, double distance) {
  std::vector<Box> boxes(points.size()), triangle_boxes(surface.triangles().size());
  for (std::size_t n = 0; n < points.size(); ++n) boxes[n] = box_of(distance, points[n].position(x));
  for (std::size_t n = 0; n < triangle_boxes.size(); ++n) {
    const auto& v = surface.triangles()[n].vertices;
    triangle_boxes[n] = box_of(0.0, x[v[0]], x[v[1]], x[v[2]]);
  }
  return overlapping_pairs(Bvh(boxes), Bvh(triangle_boxes), [&](std::int32_t n, std::int32_t t) {
    const SurfacePoint& point = points[n];
    const auto& triangle = surface.triangles()[t];
    for (int k = 0; k < point.num_nodes; ++k) {
      if (surface.is_incident(triangle, point.nodes[k])) return false;
    }
    return true;
  });
}

std::vector<PointPair> point_pairs(const CollisionSurface& surface, const FeatureMultiplicities& multiplicities,
                                   std::span<const SurfacePoint> points, std::span<const BoxPair> candidates,
                                   std::span<const Vector3<double>> x, double reach) {
  std::vector<PointPair> pairs;
  FeatureCounter counter(surface, multiplicities, x, reach);
  for (std::size_t begin = 0, end = 0; begin < candidates.size(); begin = end) {
    const std::int32_t point = candidates[begin].first;
    while (end < candidates.size() && candidates[end].first == point) ++end;
    const auto near = candidates.subspan(begin, end - begin);
    for (const Count& count : counter.count(points[point].position(x), points[point].group, near)) {
      pairs.push_back({point, count.feature, count.kind, count.number});
    }
  }
  return pairs;
}

std::vector<EdgePair> edge_pairs(const CollisionSurface& surface, std::span<const BoxPair> candidates,
                                 std::span<const Vector3<double>> x, double reach, double edge_share) {
  std::vector<EdgePair> pairs;
  const auto X = surface.rest_positions();
  for (const BoxPair& pair : candidates) {
    const auto &a = surface.edges()[pair.first], &b = surface.edges()[pair.second];
    if (a.is_flat || b.is_flat) continue;
    const auto [a0, a1] = a.vertices;
    const auto [b0, b1] = b.vertices;
    if (!(closest_edge_edge(std::array{x[a0], x[a1], x[b0], x[b1]}).squared_distance < reach * reach)) continue;
    const double share = a.is_loose && b.is_loose ? 1.0 : edge_share;
    pairs.push_back({pair.first, pair.second, 0.25 * share * (a.area + b.area),
                     mollifier_threshold(std::array{X[a0], X[a1], X[b0], X[b1]})});
  }
  return pairs;
}

namespace {

/// The nearest feature of a body, so far.
struct NearestFeature {
  std::int32_t body = 0;
  double squared_distance = 0.0, steepness = -1.0;
  bool is_within = false;  ///< the foot is within a triangle
  PointPair pair;
};

}  // namespace

std::vector<PointPair> nearest_pairs(const CollisionSurface& surface, const FeatureMultiplicities& multiplicities,
                                     std::span<const SurfacePoint> points, std::span<const BoxPair> candidates,
                                     std::span<const Vector3<double>> x, double reach, double depth) {
  constexpr double rounding = 1e-12;   // of squared distances to one feature of several triangles
  constexpr double on_surface = 1e-9;  // relative to the longest edge
  const double farthest = std::max(reach, depth);
  std::vector<PointPair> pairs;
  std::vector<NearestFeature> of_bodies;
  for (std::size_t begin = 0, end = 0; begin < candidates.size(); begin = end) {
    const std::int32_t point = candidates[begin].first;
    while (end < candidates.size() && candidates[end].first == point) ++end;
    const std::int32_t own = surface.vertices()[points[point].nodes[0]].body;
    const Vector3<double> p = points[point].position(x);
    of_bodies.clear();
    for (const BoxPair& candidate : candidates.subspan(begin, end - begin)) {
      const auto& triangle = surface.triangles()[candidate.second];
      if (triangle.body == own) continue;
      const auto& v = triangle.vertices;
      const PointTriangle closest = closest_point_triangle(std::array{p, x[v[0]], x[v[1]], x[v[2]]});
      const double square = closest.squared_distance;
      if (!(square <= farthest * farthest)) continue;
      auto known = std::ranges::find(of_bodies, triangle.body, &NearestFeature::body);
      // Feet within two triangles are two places. The nearer one counts, so that the distance is continuous.
      const bool are_two = closest.feature == TriangleFeature::face && known != of_bodies.end() && known->is_within;
      const double equal = are_two ? 0.0 : rounding;
      if (known != of_bodies.end() && square > known->squared_distance * (1.0 + equal)) continue;
      Vector3<double> r = p;
      for (std::size_t k = 0; k < 3; ++k) r = r - closest.barycentric[k] * x[v[k]];
      const Vector3<double> normal = cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]);
      const double along = dot(normal, r), steepness = std::abs(along) / norm(normal);
      const bool is_same = known != of_bodies.end() && square >= known->squared_distance * (1.0 - equal);
      if (is_same && steepness <= known->steepness) continue;
      if (known == of_bodies.end()) known = of_bodies.insert(known, NearestFeature{});
      PointPair pair{point, candidate.second, FeatureKind::face, 1, static_cast<std::int8_t>(along < 0.0 ? -1 : 1)};
      const int feature = static_cast<int>(closest.feature);
      // A point on an edge or a vertex has no direction from it: it counts as one of the face.
      const bool is_on_surface = square <= on_surface * on_surface * surface.longest_edge() * surface.longest_edge();
      if (is_on_surface) {
        pair.kind = FeatureKind::face;
      } else if (closest.feature < TriangleFeature::edge_01) {
        pair.kind = FeatureKind::vertex;
        pair.feature = v[feature];
      } else if (closest.feature != TriangleFeature::face) {
        pair.kind = FeatureKind::edge;
        pair.feature = triangle.edges[feature - static_cast<int>(TriangleFeature::edge_01)];
      }
      *known = {triangle.body, std::min(square, is_same ? known->squared_distance : square), steepness,
                closest.feature == TriangleFeature::face, pair};
    }
    std::ranges::sort(of_bodies, {}, [](const NearestFeature& nearest) { return nearest.pair; });
    const std::int32_t group = points[point].group;
    for (const NearestFeature& nearest : of_bodies) {
      const auto& [kind, feature] = std::pair(nearest.pair.kind, nearest.pair.feature);
      const bool is_on_rim = (kind == FeatureKind::edge && multiplicities.edge(group, feature) != 1) ||
                             (kind == FeatureKind::vertex && multiplicities.vertex(group, feature) != 1);
      if (is_on_rim) continue;
      const double limit = nearest.pair.side < 0 ? depth : reach;
      if (nearest.squared_distance < limit * limit) pairs.push_back(nearest.pair);
    }
  }
  return pairs;
}

namespace {

/// The parts that follow from the separation of the nodes at `x`.
template <int N>
PairGeometry geometry_at(const Stencil<N>& stencil, const std::array<std::int32_t, N>& nodes, int num_first_nodes,
                         std::span<const Vector3<double>> x, const auto& sign_at) {
  std::array<Vector3<double>, N> at;
  for (int n = 0; n < N; ++n) at[n] = x[nodes[n]];
  const Separation<N> closest = separation<N>(stencil, at);
  const double sign = sign_at(closest);
  PairGeometry pair{.num_nodes = N,
                    .num_first_nodes = num_first_nodes,
                    .distance = sign * closest.distance,
                    .normal = sign * closest.normal};
  std::ranges::copy(nodes, pair.nodes.begin());
  std::ranges::copy(closest.weights, pair.weights.begin());
  return pair;
}

}  // namespace

PairGeometry geometry_of(const CollisionSurface& surface, std::span<const SurfacePoint> points, const PointPair& pair,
                         std::span<const Vector3<double>> x) {
  const SurfacePoint& point = points[pair.point];
  const auto between = [&]<int A, int B>(const std::array<std::int32_t, B>& feature) {
    std::array<std::int32_t, A + B> nodes{};
    std::array<Vector3<double>, 1 + B> simple{point.position(x)};
    std::copy_n(point.nodes.begin(), A, nodes.begin());
    for (int b = 0; b < B; ++b) {
      nodes[A + b] = feature[b];
      simple[1 + b] = x[feature[b]];
    }
    return geometry_at<A + B>(point_feature_stencil<A, B>(point.weights, simple), nodes, A, x,
                              [&](const auto& closest) { return sign_of(surface, pair, closest, x); });
  };
  const auto with = [&]<int B>(const std::array<std::int32_t, B>& feature) {
    if (point.num_nodes == 1) return between.template operator()<1, B>(feature);
    return point.num_nodes == 2 ? between.template operator()<2, B>(feature)
                                : between.template operator()<3, B>(feature);
  };
  PairGeometry result;
  if (pair.kind == FeatureKind::vertex) result = with.template operator()<1>({pair.feature});
  if (pair.kind == FeatureKind::edge) result = with.template operator()<2>(surface.edges()[pair.feature].vertices);
  if (pair.kind == FeatureKind::face) result = with.template operator()<3>(surface.triangles()[pair.feature].vertices);
  result.weight = 0.5 * point.area * pair.multiplicity;
  result.body = surface.vertices()[point.nodes[0]].body;
  result.other = body_of(surface, pair);
  result.first_vertex = first_vertex(surface, pair);
  return result;
}

PairGeometry geometry_of(const CollisionSurface& surface, const EdgePair& pair, std::span<const Vector3<double>> x) {
  const auto &a = surface.edges()[pair.a], &b = surface.edges()[pair.b];
  const std::array nodes{a.vertices[0], a.vertices[1], b.vertices[0], b.vertices[1]};
  const std::array ends{x[nodes[0]], x[nodes[1]], x[nodes[2]], x[nodes[3]]};
  const double mollifier = edge_edge_mollifier_value(ends, pair.threshold);
  PairGeometry result;
  if (mollifier > 0.0)
    result = geometry_at<4>(stencil_of(closest_edge_edge(ends)), nodes, 2, x, [](const auto&) { return 1.0; });
  result.weight = pair.weight * mollifier;
  result.body = a.body;
  result.other = b.body;
  result.first_vertex = a.vertices[0];
  return result;
}

}  // namespace pliant
