#include "collision/triangle_tree.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using Bounds = TriangleTree::Bounds;

constexpr std::int32_t most_in_leaf = 4;
/// Distances that differ by less, relatively, are equal but for rounding.
constexpr double rounding = 1e-9;

Bounds bounds_of(const CollisionSurface::Triangle& triangle, std::span<const Vector3<double>> x) {
  const auto [a, b, c] = triangle.vertices;
  Bounds bounds;
  for (std::size_t k = 0; k < 3; ++k) {
    bounds.low[k] = std::min({x[a][k], x[b][k], x[c][k]});
    bounds.high[k] = std::max({x[a][k], x[b][k], x[c][k]});
  }
  return bounds;
}

void include(Bounds& bounds, const Bounds& other) {
  for (std::size_t k = 0; k < 3; ++k) {
    bounds.low[k] = std::min(bounds.low[k], other.low[k]);
    bounds.high[k] = std::max(bounds.high[k], other.high[k]);
  }
}

double squared_distance(const Bounds& a, const Bounds& b) {
  double square = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = std::max({0.0, a.low[k] - b.high[k], b.low[k] - a.high[k]});
    square += d * d;
  }
  return square;
}

/// The search for the nearest places of two trees, which forgets all that is farther than the best so far.
class NearestSearch {
 public:
  NearestSearch(const TriangleTree& a, const TriangleTree& b, double within,
                const std::function<bool(std::int32_t, std::int32_t)>& may_touch)
      : a_(a), b_(b), surface_(a.surface()), x_(a.positions()), may_touch_(may_touch), limit_(within) {}

  NearestPlaces operator()() {
    if (!a_.nodes().empty() && !b_.nodes().empty()) visit(0, 0);
    return best_;
  }

 private:
  double squared_limit() const {
    const double limit = std::min(limit_, best_.distance * (1.0 + rounding));
    return limit * limit;
  }

  void visit(std::int32_t first, std::int32_t second) {
    const auto &one = a_.nodes()[first], &two = b_.nodes()[second];
    if (squared_distance(one.bounds, two.bounds) > squared_limit()) return;
    const bool is_leaf = one.second_child == 0, is_other_leaf = two.second_child == 0;
    if (is_leaf && is_other_leaf) {
      compare(one, two);
      return;
    }
    const bool splits_first = !is_leaf && (is_other_leaf || one.count >= two.count);
    std::array<std::array<std::int32_t, 2>, 2> next{};
    if (splits_first) {
      next = {{{first + 1, second}, {one.second_child, second}}};
    } else {
      next = {{{first, second + 1}, {first, two.second_child}}};
    }
    const auto distance = [&](const std::array<std::int32_t, 2>& nodes) {
      return squared_distance(a_.nodes()[nodes[0]].bounds, b_.nodes()[nodes[1]].bounds);
    };
    if (distance(next[1]) < distance(next[0])) std::swap(next[0], next[1]);
    for (const auto& [m, n] : next) visit(m, n);
  }

  void compare(const TriangleTree::Node& one, const TriangleTree::Node& two) {
    for (std::int32_t i = 0; i < one.count; ++i) {
      for (std::int32_t j = 0; j < two.count; ++j) {
        const std::int32_t s = a_.numbers()[one.first + i], t = b_.numbers()[two.first + j];
        if (s == t || !may_touch_(s, t)) continue;
        const auto &first = surface_.triangles()[s], &second = surface_.triangles()[t];
        compare_vertices(first, second);
        compare_vertices(second, first);
        for (const std::int32_t e : first.edges) {
          for (const std::int32_t f : second.edges) compare_edges(surface_.edges()[e], surface_.edges()[f]);
        }
      }
    }
  }

  void compare_vertices(const CollisionSurface::Triangle& of, const CollisionSurface::Triangle& triangle) {
    const auto [a, b, c] = triangle.vertices;
    for (const std::int32_t v : of.vertices) {
      if (surface_.is_incident(triangle, v)) continue;
      const auto square_at = [&, a = a, b = b, c = c](std::span<const Vector3<double>> x) {
        return closest_point_triangle(std::array{x[v], x[a], x[b], x[c]}).squared_distance;
      };
      consider(square_at, {0.0, x_[v], of.body, triangle.body, true});
    }
  }

  void compare_edges(const CollisionSurface::Edge& one, const CollisionSurface::Edge& two) {
    if (surface_.is_incident(one, two)) return;
    const auto at = [&](std::span<const Vector3<double>> x) {
      return std::array{x[one.vertices[0]], x[one.vertices[1]], x[two.vertices[0]], x[two.vertices[1]]};
    };
    const auto square_at = [&](std::span<const Vector3<double>> x) {
      return closest_edge_edge(at(x)).squared_distance;
    };
    const auto ends = at(x_);
    const EdgeEdge closest = closest_edge_edge(ends);
    const Vector3<double> p = ends[0] + closest.s * (ends[1] - ends[0]), q = ends[2] + closest.t * (ends[3] - ends[2]);
    consider(square_at, {0.0, 0.5 * (p + q), one.body, two.body, false});
  }

  template <class SquareAt>
  void consider(const SquareAt& square_at, NearestPlaces found) {
    const double square = square_at(x_);
    if (square > squared_limit()) return;
    if (found.body == found.other && square > 0.25 * square_at(surface_.rest_positions())) return;
    found.distance = std::sqrt(square);
    // Where edges are parallel the places on them are arbitrary, but a vertex is as near.
    const bool is_less = found.distance < best_.distance * (1.0 - rounding);
    const bool is_better =
        found.is_vertex != best_.is_vertex ? found.is_vertex : level_of(found.place) < level_of(best_.place);
    if (!is_less && !is_better) return;
    found.distance = std::min(found.distance, best_.distance);
    best_ = found;
  }

  const TriangleTree &a_, &b_;
  const CollisionSurface& surface_;
  std::span<const Vector3<double>> x_;
  const std::function<bool(std::int32_t, std::int32_t)>& may_touch_;
  double limit_;
  NearestPlaces best_;
};

}  // namespace

double level_of(const Vector3<double>& place) {
  return dot(Vector3<double>{1.0, 0.6180339887, 0.3819660113}, place);
}

TriangleTree::TriangleTree(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                           std::vector<std::int32_t> numbers)
    : surface_(surface), x_(x), numbers_(std::move(numbers)) {
  if (!numbers_.empty()) build(0, static_cast<std::int32_t>(numbers_.size()));
}

void TriangleTree::build(std::int32_t first, std::int32_t count) {
  const auto place = nodes_.size();
  const auto mine = std::span(numbers_).subspan(first, count);
  Node node{bounds_of(surface_.triangles()[mine[0]], x_), first, count, 0};
  for (const std::int32_t t : mine) include(node.bounds, bounds_of(surface_.triangles()[t], x_));
  nodes_.push_back(node);
  if (count <= most_in_leaf) return;
  const Vector3<double> size = node.bounds.high - node.bounds.low;
  const auto axis = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
  const auto middle = [&](std::int32_t t) {
    const auto [a, b, c] = surface_.triangles()[t].vertices;
    return x_[a][axis] + x_[b][axis] + x_[c][axis];
  };
  const std::int32_t half = count / 2;
  std::ranges::nth_element(mine, mine.begin() + half, {}, middle);
  build(first, half);
  nodes_[place].second_child = static_cast<std::int32_t>(nodes_.size());
  build(first + half, count - half);
}

NearestPlaces nearest_places(const TriangleTree& a, const TriangleTree& b, double within,
                             const std::function<bool(std::int32_t, std::int32_t)>& may_touch) {
  return NearestSearch(a, b, within, may_touch)();
}

DepthBelow::DepthBelow(const TriangleTree& tree) : tree_(tree) {
  const CollisionSurface& surface = tree.surface();
  const auto x = tree.positions();
  normals_of_edges_.resize(surface.edges().size());
  normals_of_vertices_.resize(surface.vertices().size());
  std::vector<int> triangles_at(surface.edges().size(), 0);
  for (const std::int32_t t : tree.numbers()) {
    const auto& triangle = surface.triangles()[t];
    const auto& v = triangle.vertices;
    const Vector3<double> area = cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]);
    if (!(norm(area) > 0.0)) continue;
    const Vector3<double> normal = unit(area);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3<double> to_next = x[v[(k + 1) % 3]] - x[v[k]], to_last = x[v[(k + 2) % 3]] - x[v[k]];
      const double angle = std::atan2(norm(cross(to_next, to_last)), dot(to_next, to_last));
      normals_of_vertices_[v[k]] = normals_of_vertices_[v[k]] + angle * normal;
      normals_of_edges_[triangle.edges[k]] = normals_of_edges_[triangle.edges[k]] + normal;
      ++triangles_at[triangle.edges[k]];
    }
  }
  is_rim_edge_.assign(surface.edges().size(), 0);
  is_rim_vertex_.assign(surface.vertices().size(), 0);
  for (std::size_t e = 0; e < triangles_at.size(); ++e) {
    if (triangles_at[e] != 1) continue;
    is_closed_ = false;
    is_rim_edge_[e] = 1;
    for (const std::int32_t v : surface.edges()[e].vertices) is_rim_vertex_[v] = 1;
  }
}

template <class Counts>
Foot DepthBelow::nearest(const Vector3<double>& p, const Counts& counts) const {
  Foot foot;
  if (tree_.nodes().empty()) return foot;
  const CollisionSurface& surface = tree_.surface();
  const auto x = tree_.positions();
  const Bounds at{p, p};
  double least = std::numeric_limits<double>::infinity();
  std::vector<std::int32_t> open{0};
  while (!open.empty()) {
    const std::int32_t number = open.back();
    open.pop_back();
    const auto& node = tree_.nodes()[number];
    if (squared_distance(node.bounds, at) >= least) continue;
    if (node.second_child != 0) {
      std::array<std::int32_t, 2> next{number + 1, node.second_child};
      const auto distance = [&](std::int32_t n) { return squared_distance(tree_.nodes()[n].bounds, at); };
      if (distance(next[0]) < distance(next[1])) std::swap(next[0], next[1]);
      open.insert(open.end(), next.begin(), next.end());
      continue;
    }
    for (std::int32_t i = 0; i < node.count; ++i) {
      const std::int32_t t = tree_.numbers()[node.first + i];
      if (!counts(t)) continue;
      const auto [a, b, c] = surface.triangles()[t].vertices;
      const PointTriangle found = closest_point_triangle(std::array{p, x[a], x[b], x[c]});
      if (!(found.squared_distance < least)) continue;
      least = found.squared_distance;
      foot.triangle = t;
      foot.closest = found;
    }
  }
  if (foot.triangle < 0) return foot;
  const auto& triangle = surface.triangles()[foot.triangle];
  const auto& v = triangle.vertices;
  const auto feature = static_cast<std::size_t>(foot.closest.feature);
  for (std::size_t k = 0; k < 3; ++k) foot.place = foot.place + foot.closest.barycentric[k] * x[v[k]];
  if (feature < 3) {
    foot.is_on_rim = is_rim_vertex_[v[feature]] != 0;
    foot.normal = normals_of_vertices_[v[feature]];
  } else if (foot.closest.feature != TriangleFeature::face) {
    const std::int32_t edge = triangle.edges[feature - static_cast<std::size_t>(TriangleFeature::edge_01)];
    foot.is_on_rim = is_rim_edge_[edge] != 0;
    foot.normal = normals_of_edges_[edge];
  } else {
    foot.normal = cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]);
  }
  return foot;
}

Foot DepthBelow::foot(const Vector3<double>& p) const {
  return nearest(p, [](std::int32_t) { return true; });
}

Foot DepthBelow::foot_facing(const Vector3<double>& direction, const Vector3<double>& p) const {
  constexpr double least_cosine = 0.1;
  const auto x = tree_.positions();
  return nearest(p, [&](std::int32_t t) {
    const auto [a, b, c] = tree_.surface().triangles()[t].vertices;
    const Vector3<double> area = cross(x[b] - x[a], x[c] - x[a]);
    return dot(area, direction) < -least_cosine * norm(area) * norm(direction);
  });
}

double DepthBelow::operator()(const Vector3<double>& p) const {
  const Foot at = foot(p);
  if (at.triangle < 0 || at.is_on_rim) return 0.0;
  return dot(at.normal, p - at.place) < 0.0 ? std::sqrt(at.closest.squared_distance) : 0.0;
}

}  // namespace pliant
