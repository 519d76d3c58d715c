#include "collision/overlaps.hpp"

#include "collision/intersection.hpp"
#include "collision/triangle_tree.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace pliant {
namespace {

/// Depths that differ by less, relatively, are equal but for rounding.
constexpr double equal_depths = 1e-9;

using SurfaceFacet = CollisionSurface::Triangle;
using Points = std::array<Vector3<double>, 7>;

/// Corners, middles of the edges, centre.
Points points_on(const SurfaceFacet& triangle, std::span<const Vector3<double>> x) {
  const auto& v = triangle.vertices;
  const auto &a = x[v[0]], &b = x[v[1]], &c = x[v[2]];
  return {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), 1.0 / 3.0 * (a + b + c)};
}

/// Whether an edge of the first triangle that shares no vertex with the second one meets it.
bool passes_through(const CollisionSurface& surface, std::span<const Vector3<double>> x, const SurfaceFacet& of_edges,
                    const SurfaceFacet& triangle) {
  if (triangle.is_segment()) return false;
  const auto [a, b, c] = triangle.vertices;
  for (const std::int32_t edge : of_edges.sides()) {
    const auto& ends = surface.edges()[edge].vertices;
    if (surface.is_incident(triangle, ends[0]) || surface.is_incident(triangle, ends[1])) continue;
    if (segment_meets_triangle({x[ends[0]], x[ends[1]]}, {x[a], x[b], x[c]})) return true;
  }
  return false;
}

class OverlapFinder {
 public:
  OverlapFinder(const CollisionSurface& surface, std::span<const Vector3<double>> x, const ContactSets& sets)
      : surface_(surface), x_(x), sets_(sets) {
    for (std::size_t t = 0; t < surface.triangles().size(); ++t) {
      of_body_[surface.triangles()[t].body].push_back(static_cast<std::int32_t>(t));
    }
  }

  std::vector<SurfaceOverlap> operator()() {
    std::vector<Box> boxes;
    for (const auto& triangle : surface_.triangles()) {
      const auto [a, b, c] = triangle.vertices;
      boxes.push_back(box_of(0.0, x_[a], x_[b], x_[c]));
    }
    const auto triangles = surface_.triangles();
    std::map<std::pair<std::int32_t, std::int32_t>, std::vector<BoxPair>> meetings;  // by bodies
    for (const BoxPair& pair : overlapping_pairs(Bvh(boxes), [&](std::int32_t i, std::int32_t j) {
           const auto &a = triangles[i], &b = triangles[j];
           return sets_(a.group, b.group) && (passes_through(surface_, x_, a, b) || passes_through(surface_, x_, b, a));
         })) {
      const auto [low, high] = std::minmax(triangles[pair.first].body, triangles[pair.second].body);
      meetings[{low, high}].push_back(pair);
    }
    for (const auto& [body, mine] : of_body_) {
      for (const auto& [other, theirs] : of_body_) {
        if (body < other && may_contain(mine, theirs)) meetings.try_emplace({body, other});
      }
    }
    std::vector<SurfaceOverlap> found;
    for (const auto& [bodies, pairs] : meetings) {
      SurfaceOverlap overlap = overlap_of(bodies.first, bodies.second, pairs);
      if (!overlap.triangles.empty()) found.push_back(std::move(overlap));
    }
    return found;
  }

 private:
  bool is_thin(std::int32_t body) const { return surface_.triangles()[of_body_.at(body).front()].is_thin(); }

  /// Whether one body's box lies within the other's, and some of their triangles may touch.
  bool may_contain(const std::vector<std::int32_t>& mine, const std::vector<std::int32_t>& theirs) const {
    const auto bounds = [&](const std::vector<std::int32_t>& numbers) {
      Box box;
      for (const std::int32_t t : numbers) {
        const auto [a, b, c] = surface_.triangles()[t].vertices;
        box.include(box_of(0.0, x_[a], x_[b], x_[c]));
      }
      return box;
    };
    const Box one = bounds(mine), two = bounds(theirs);
    const auto is_within = [](const Box& inner, const Box& outer) {
      bool is_in = true;
      for (int k = 0; k < 3; ++k) is_in = is_in && outer.low[k] <= inner.low[k] && inner.high[k] <= outer.high[k];
      return is_in;
    };
    return (is_within(one, two) || is_within(two, one)) &&
           std::ranges::any_of(mine, [&](std::int32_t t) { return may_touch_any(t, theirs); });
  }

  bool may_touch_any(std::int32_t t, const std::vector<std::int32_t>& others) const {
    const std::int32_t group = surface_.triangles()[t].group;
    return std::ranges::any_of(others,
                               [&](std::int32_t other) { return sets_(group, surface_.triangles()[other].group); });
  }

  SurfaceOverlap overlap_of(std::int32_t body, std::int32_t other, const std::vector<BoxPair>& pairs) {
    SurfaceOverlap overlap{body, other, {}, 0, 0.0, {}};
    overlap.is_thin = is_thin(body) || is_thin(other);
    std::map<std::int32_t, double> depths;  // of each triangle
    for (const BoxPair& pair : pairs) {
      for (const std::int32_t t : {pair.first, pair.second}) depths[t] = 0.0;
    }
    double lowest = std::numeric_limits<double>::infinity();
    const auto include = [&](double depth, const Vector3<double>& place) {
      const double same = equal_depths * overlap.depth, level = level_of(place);
      if (depth < overlap.depth - same || (depth <= overlap.depth + same && level >= lowest)) return;
      overlap.depth = std::max(depth, overlap.depth);
      overlap.place = place;
      lowest = level;
    };
    for (const auto& [t, depth] : depths) {
      for (const std::int32_t v : surface_.triangles()[t].vertices) include(depth, x_[v]);
    }
    if (body != other) {
      add_depths(body, other, depths, include);
      add_depths(other, body, depths, include);
    }
    for (const auto& [t, depth] : depths) overlap.triangles.push_back({t, depth});
    overlap.num_places = count_places(depths, pairs);
    const auto order = [&](const OverlappingTriangle& triangle) {
      const auto& of = surface_.triangles()[triangle.number];
      double level = 0.0;
      for (const std::int32_t v : of.vertices) level += level_of(x_[v]);
      return std::pair(of.body, level);
    };
    std::ranges::sort(overlap.triangles, {}, order);
    return overlap;
  }

  /// The depths of triangles of `body` below the surface of `other`. Where that is open only those that pass through it
  /// are asked: elsewhere it has no inside. What is thin has none at all.
  template <class Include>
  void add_depths(std::int32_t body, std::int32_t other, std::map<std::int32_t, double>& depths,
                  const Include& include) const {
    const auto& theirs = of_body_.at(other);
    if (is_thin(other)) return;
    const TriangleTree tree(surface_, x_, theirs);
    const DepthBelow depth_below(tree);
    const auto& bounds = tree.nodes()[0].bounds;
    for (const std::int32_t t : of_body_.at(body)) {
      const bool passes = depths.contains(t);
      if (!passes && (!depth_below.is_closed() || !may_touch_any(t, theirs))) continue;
      for (const Vector3<double>& p : points_on(surface_.triangles()[t], x_)) {
        bool is_near = true;
        for (int k = 0; k < 3; ++k) is_near = is_near && bounds.low[k] <= p[k] && p[k] <= bounds.high[k];
        const double depth = is_near ? depth_below(p) : 0.0;
        if (!(depth > equal_depths * surface_.longest_edge())) continue;
        double& deepest = depths[t];
        deepest = std::max(deepest, depth);
        include(depth, p);
      }
    }
  }

  /// Triangles hang together if they share a vertex or pass through each other.
  int count_places(const std::map<std::int32_t, double>& depths, const std::vector<BoxPair>& pairs) const {
    std::map<std::int32_t, std::int32_t> parent;  // of triangles
    for (const auto& [t, depth] : depths) parent[t] = t;
    const auto root = [&](std::int32_t t) {
      while (parent[t] != t) t = parent[t] = parent[parent[t]];
      return t;
    };
    std::map<std::int32_t, std::int32_t> first_at;  // of vertices
    for (const auto& [t, depth] : depths) {
      for (const std::int32_t v : surface_.triangles()[t].vertices) {
        const std::int32_t first = first_at.try_emplace(v, t).first->second;
        parent[root(t)] = root(first);
      }
    }
    for (const BoxPair& pair : pairs) parent[root(pair.first)] = root(pair.second);
    return static_cast<int>(
        std::ranges::count_if(depths, [&](const auto& entry) { return root(entry.first) == entry.first; }));
  }

  const CollisionSurface& surface_;
  std::span<const Vector3<double>> x_;
  const ContactSets& sets_;
  std::map<std::int32_t, std::vector<std::int32_t>> of_body_;  // numbers of triangles
};

}  // namespace

std::vector<SurfaceOverlap> find_overlaps(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                                          const ContactSets& sets) {
  return OverlapFinder(surface, x, sets)();
}

}  // namespace pliant
