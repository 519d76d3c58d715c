#include "energy/contact/separation.hpp"

#include "collision/closest_points.hpp"
#include "collision/intersection.hpp"
#include "collision/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace pliant {
namespace {

using SurfaceFacet = CollisionSurface::Triangle;
using Places = std::vector<Vector3<double>>;

constexpr int most_steps_of_nodes = 4, most_sweeps = 60;
/// Barycentric coordinates below this count as 0, so that rounding does not decide on which feature a foot is.
constexpr double least_share = 1e-7;

/// A point of a triangle, as a mean of its corners.
struct FacetSample {
  std::array<double, 3> barycentric;
  int corner, edge;  // on which it is; -1: on none
};
constexpr double third = 1.0 / 3.0;
constexpr std::array<FacetSample, 7> samples{{{{1.0, 0.0, 0.0}, 0, -1},
                                              {{0.0, 1.0, 0.0}, 1, -1},
                                              {{0.0, 0.0, 1.0}, 2, -1},
                                              {{0.5, 0.5, 0.0}, -1, 0},
                                              {{0.0, 0.5, 0.5}, -1, 1},
                                              {{0.5, 0.0, 0.5}, -1, 2},
                                              {{third, third, third}, -1, -1}}};

/// Two points of surfaces that are too near: r = sum w_i x_i between them, as a function of the nodes, must not be less
/// than a distance along the normal n.
struct Approach {
  Vector3<double> place{}, normal{};
  std::vector<std::pair<std::int32_t, double>> weights;  // of nodes
  GapGoal goal;
  double missing = 0.0;  ///< of the wanted distance, when found [m]
};

/// A body's triangles at some positions.
struct BodySide {
  TriangleTree tree;
  DepthBelow below;
  BodySide(const CollisionSurface& surface, const Places& x, std::vector<std::int32_t> numbers)
      : tree(surface, x, std::move(numbers)), below(tree) {}
};

Vector3<double> face_normal(const SurfaceFacet& triangle, const Places& x) {
  const auto [a, b, c] = triangle.vertices;
  return cross(x[b] - x[a], x[c] - x[a]);
}

Vector3<double> unit_or_zero(const Vector3<double>& a) {
  const double size = norm(a);
  return size > 0.0 ? (1.0 / size) * a : Vector3<double>{};
}

/// The normal of the feature on which a foot lies, decided with a tolerance, and whether that is the face.
std::pair<Vector3<double>, bool> normal_at(const Foot& foot, const BodySide& side, const Places& x) {
  const SurfaceFacet& triangle = side.tree.surface().triangles()[foot.triangle];
  std::vector<std::size_t> present;
  for (std::size_t k = 0; k < 3; ++k) {
    if (foot.closest.barycentric[k] > least_share) present.push_back(k);
  }
  if (present.size() == 1) return {unit_or_zero(side.below.normal_of_vertex(triangle.vertices[present[0]])), false};
  if (present.size() == 3) return {unit_or_zero(face_normal(triangle, x)), true};
  const std::size_t edge = present[0] == 0 && present[1] == 2 ? 2 : present[0];
  return {unit_or_zero(side.below.normal_of_edge(triangle.edges[edge])), false};
}

Vector3<double> normal_at(const FacetSample& sample, const SurfaceFacet& triangle, const BodySide& side,
                          const Places& x) {
  if (sample.corner >= 0) return unit_or_zero(side.below.normal_of_vertex(triangle.vertices[sample.corner]));
  if (sample.edge >= 0) return unit_or_zero(side.below.normal_of_edge(triangle.edges[sample.edge]));
  return unit_or_zero(face_normal(triangle, x));
}

/// What is too near in one of the surfaces.
class ApproachFinder {
 public:
  enum class Points { corners, all };

  ApproachFinder(const BodySurfaces& surfaces, const ContactSets& sets, const GapGoals& goals)
      : surfaces_(surfaces), surface_(surfaces.surface()), sets_(sets), goals_(goals) {
    for (std::size_t t = 0; t < surface_.triangles().size(); ++t) {
      of_body_[surface_.triangles()[t].body].push_back(static_cast<std::int32_t>(t));
    }
  }

  /// Those where the distance is less than the wanted one, for corners, or than the least one, for all; in an order
  /// that does not depend on numbers.
  std::vector<Approach> operator()(std::span<const Vector3<double>> nodes, Points points) {
    x_.assign(nodes.begin(), nodes.end());
    surfaces_.place(x_);
    found_.clear();
    std::map<std::int32_t, BodySide> sides;
    for (const auto& [body, numbers] : of_body_) sides.try_emplace(body, surface_, x_, numbers);
    for (const auto& [body, mine] : sides) {
      for (const auto& [other, theirs] : sides) {
        if (body == other || !(goals_.of(body, other).wanted > 0.0)) continue;
        add_points(mine, theirs, goals_.of(body, other), points);
        if (points == Points::all && body < other) add_edges(mine, theirs, goals_.of(body, other));
      }
    }
    std::ranges::sort(found_, {}, [](const Approach& a) { return level_of(a.place); });
    return std::move(found_);
  }

 private:
  bool are_apart(const SurfaceFacet& a, const SurfaceFacet& b) const {
    return !sets_(a.group, b.group) || surface_.is_incident(a, b);
  }

  void add_points(const BodySide& mine, const BodySide& theirs, const GapGoal& goal, Points points) {
    const auto& bounds = theirs.tree.nodes()[0].bounds;
    const bool only_corners = points == Points::corners;
    const double near = only_corners ? goal.wanted : goal.least;
    for (const std::int32_t t : mine.tree.numbers()) {
      const SurfaceFacet& triangle = surface_.triangles()[t];
      const auto& v = triangle.vertices;
      for (const FacetSample& sample : samples) {
        if (only_corners && sample.corner < 0) continue;
        Vector3<double> p{};
        for (std::size_t k = 0; k < 3; ++k) p = p + sample.barycentric[k] * x_[v[k]];
        bool is_near = true;
        for (std::size_t k = 0; k < 3; ++k) {
          is_near = is_near && bounds.low[k] - near <= p[k] && p[k] <= bounds.high[k] + near;
        }
        if (!is_near) continue;
        const Vector3<double> outwards = normal_at(sample, triangle, mine, x_);
        Foot foot = theirs.below.foot(p);
        if (foot.is_on_rim) continue;
        if (dot(foot.normal, p - foot.place) < 0.0) {
          // Near an edge the nearest face may be one along which the bodies do not part.
          const Foot facing = theirs.below.foot_facing(outwards, p);
          if (facing.triangle >= 0 && facing.closest.feature == TriangleFeature::face &&
              norm(p - facing.place) < 1.2 * goal.depth + goal.wanted) {
            foot = facing;
          }
        }
        const SurfaceFacet& met = surface_.triangles()[foot.triangle];
        if (are_apart(triangle, met)) continue;
        const Vector3<double> between = p - foot.place;
        const auto [their_normal, is_on_face] = normal_at(foot, theirs, x_);
        const double side = dot(their_normal, between) < 0.0 ? -1.0 : 1.0, distance = side * norm(between);
        if (distance >= near || distance < -goal.deepest) continue;
        Vector3<double> normal = their_normal;
        if (!is_on_face && std::abs(distance) > 0.1 * goal.least) {
          normal = (1.0 / distance) * between;
        } else if (!is_on_face) {
          // Where edges or corners meet, half of the normals of both: of two blocks side by side that of their faces.
          normal = unit_or_zero(their_normal - outwards);
        }
        found_.push_back(complete({p, normal, {}, goal, goal.wanted - distance}, v, sample.barycentric, met.vertices,
                                  foot.closest.barycentric));
      }
    }
  }

  void add_edges(const BodySide& mine, const BodySide& theirs, const GapGoal& goal) {
    const auto boxes = [&](const BodySide& side) {
      std::vector<Box> result;
      for (const std::int32_t t : side.tree.numbers()) {
        const auto [a, b, c] = surface_.triangles()[t].vertices;
        result.push_back(box_of(0.5 * goal.least, x_[a], x_[b], x_[c]));
      }
      return result;
    };
    Bvh(boxes(mine)).for_each_overlap(Bvh(boxes(theirs)), [&](std::int32_t i, std::int32_t j) {
      const SurfaceFacet& a = surface_.triangles()[mine.tree.numbers()[i]];
      const SurfaceFacet& b = surface_.triangles()[theirs.tree.numbers()[j]];
      if (are_apart(a, b)) return;
      // Where triangles meet, only the pair that parts them by the least motion: others are behind each other.
      const bool meet = triangles_meet(corners(a), corners(b));
      std::optional<Approach> least;
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t l = 0; l < 3; ++l) {
          auto pair = edge_pair(mine, a, k, theirs, b, l, goal);
          if (!pair) continue;
          if (!meet && pair->missing < goal.wanted) found_.push_back(std::move(*pair));
          if (meet && (!least || pair->missing < least->missing)) least = std::move(pair);
        }
      }
      if (least) found_.push_back(std::move(*least));
    });
  }

  std::array<Vector3<double>, 3> corners(const SurfaceFacet& triangle) const {
    const auto [a, b, c] = triangle.vertices;
    return {x_[a], x_[b], x_[c]};
  }

  /// Edges k and l that are too near along the normals of both, or have passed through each other.
  std::optional<Approach> edge_pair(const BodySide& mine, const SurfaceFacet& a, std::size_t k, const BodySide& theirs,
                                    const SurfaceFacet& b, std::size_t l, const GapGoal& goal) const {
    const std::size_t k_next = (k + 1) % 3, l_next = (l + 1) % 3;
    const std::array ends{x_[a.vertices[k]], x_[a.vertices[k_next]], x_[b.vertices[l]], x_[b.vertices[l_next]]};
    const EdgeEdge closest = closest_edge_edge(ends);
    if (closest.a != EdgeFeature::inside || closest.b != EdgeFeature::inside) return std::nullopt;
    const Vector3<double> across = cross(ends[1] - ends[0], ends[3] - ends[2]);
    if (!(norm(across) > 1e-3 * norm(ends[1] - ends[0]) * norm(ends[3] - ends[2]))) return std::nullopt;
    const Vector3<double> my_normal = unit_or_zero(mine.below.normal_of_edge(a.edges[k])),
                          their_normal = unit_or_zero(theirs.below.normal_of_edge(b.edges[l]));
    const Vector3<double> normal = (dot(across, their_normal - my_normal) < 0.0 ? -1.0 : 1.0) * unit(across);
    constexpr double least_cosine = 0.5;
    if (dot(normal, their_normal) < least_cosine || -dot(normal, my_normal) < least_cosine) return std::nullopt;
    const Vector3<double> p = ends[0] + closest.s * (ends[1] - ends[0]), q = ends[2] + closest.t * (ends[3] - ends[2]);
    const double distance = dot(normal, p - q);
    if (distance >= goal.least || distance < -goal.deepest) return std::nullopt;
    std::array<double, 3> of_a{}, of_b{};
    of_a[k] = 1.0 - closest.s;
    of_a[k_next] = closest.s;
    of_b[l] = 1.0 - closest.t;
    of_b[l_next] = closest.t;
    return complete({p, normal, {}, goal, goal.wanted - distance}, a.vertices, of_a, b.vertices, of_b);
  }

  /// With its weights.
  Approach complete(Approach approach, const std::array<std::int32_t, 3>& mine, const std::array<double, 3>& of_mine,
                    const std::array<std::int32_t, 3>& theirs, const std::array<double, 3>& of_theirs) const {
    const auto include = [&](std::int32_t vertex, double weight) {
      if (weight == 0.0) return;
      const auto support = surfaces_.support(vertex);
      for (int a = 0; a < support.size; ++a) {
        const auto same =
            std::ranges::find(approach.weights, support.nodes[a], &std::pair<std::int32_t, double>::first);
        if (same != approach.weights.end()) {
          same->second += weight * support.weights[a];
        } else {
          approach.weights.emplace_back(support.nodes[a], weight * support.weights[a]);
        }
      }
    };
    for (std::size_t k = 0; k < 3; ++k) include(mine[k], of_mine[k]);
    for (std::size_t k = 0; k < 3; ++k) include(theirs[k], -of_theirs[k]);
    return approach;
  }

  const BodySurfaces& surfaces_;
  const CollisionSurface& surface_;
  const ContactSets& sets_;
  const GapGoals& goals_;
  std::map<std::int32_t, std::vector<std::int32_t>> of_body_;  // numbers of triangles
  Places x_;                                                   // of the vertices
  std::vector<Approach> found_;
};

double distance(const Approach& approach, std::span<const Vector3<double>> x) {
  double r = 0.0;
  for (const auto& [node, weight] : approach.weights) r += weight * dot(approach.normal, x[node]);
  return r;
}

/// Half of what is missing, for the node of each corner; of several bodies on one side the one that needs the most.
void step_of_nodes(const std::vector<Approach>& approaches, std::span<Vector3<double>> x) {
  Places moved(x.size());
  for (const Approach& approach : approaches) {
    const auto node = static_cast<std::size_t>(approach.weights.front().first);
    const double step = 0.5 * (approach.goal.wanted - distance(approach, x)),
                 missing = step - dot(approach.normal, moved[node]);
    if (missing > 0.0) moved[node] = moved[node] + missing * approach.normal;
  }
  for (std::size_t node = 0; node < x.size(); ++node) x[node] = x[node] + moved[node];
}

/// One after another, by the least motion; between the least and the wanted distance, so that the next ones find it
/// done.
void sweep(const std::vector<Approach>& approaches, std::span<Vector3<double>> x) {
  for (const Approach& approach : approaches) {
    const double now = distance(approach, x);
    if (now >= approach.goal.least) continue;
    double square = 0.0;
    for (const auto& [node, weight] : approach.weights) square += weight * weight;
    const double missing = 0.5 * (approach.goal.least + approach.goal.wanted) - now;
    for (const auto& [node, weight] : approach.weights) {
      x[node] = x[node] + (missing * weight / square) * approach.normal;
    }
  }
}

}  // namespace

void move_apart(std::span<const BodySurfaces* const> surfaces, const ContactSets& sets, const GapGoals& goals,
                std::span<Vector3<double>> x) {
  std::vector<ApproachFinder> finders;
  for (const BodySurfaces* of : surfaces) finders.emplace_back(*of, sets, goals);
  using Points = ApproachFinder::Points;
  for (int step = 0; step < most_steps_of_nodes; ++step) {
    const auto approaches = finders.front()(x, Points::corners);
    if (approaches.empty()) break;
    step_of_nodes(approaches, x);
  }
  for (int count = 0; count < most_sweeps; ++count) {
    bool is_done = true;
    for (ApproachFinder& finder : finders) {
      const auto approaches = finder(x, Points::all);
      is_done = is_done && approaches.empty();
      sweep(approaches, x);
    }
    if (is_done) return;
  }
}

}  // namespace pliant
