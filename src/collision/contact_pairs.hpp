/// The potential of contact between surfaces, as pairs of what is near.
///
///     W = sum_p A_p / 2 [sum_T U(d(p, T)) - sum_e m_e U(d(p, e)) + sum_v m_v U(d(p, v))]
///         + edge_share sum_(a,b) (A_a + A_b) / 4 m U(d(a, b))
///
/// over the points p of a rule on the surface with areas A_p, each of which sees the triangles within reach, less their
/// inner edges, plus their inner vertices. With the multiplicities m_e = (triangles at e) - 1 and m_v = 1 - (triangles
/// at v) + sum of m_e over the edges at v, every place of the surface counts exactly once (inclusion-exclusion): on a
/// closed surface m_e = m_v = 1, on the boundary of an open one 0. Where the surface is flat, the sum is U of the
/// distance of its plane, whatever the triangulation (Li et al. 2023, Convergent Incremental Potential Contact,
/// section 4). A point does not see the triangles of which it is a part, which count in m nevertheless: what is left of
/// the triangles around them cancels, so that a flat surface does not feel itself. Each side contributes one half.
/// Corners are points of the rule, and pairs of edges have a part of their own, faded out by m as they become parallel:
/// with a barrier no vertex passes a triangle and no edge another. Only the first sum makes a uniform pressure; the
/// second adds to it where edges cross, so that edge_share should be small. Flat edges of rigid parts have no share: an
/// edge cannot reach one without a vertex that meets the plane, or a crossing of the plane's rim.
///
/// A segment of a rod (collision/surface.hpp) is a triangle that is nothing but its edge: what its points see, and what
/// others see of it, is the same sum, in which two segments at a vertex have m_v = -1. Its points have areas of its
/// thickness. Where edges of two rods cross there is nothing but the second sum, which counts fully for them.
///
/// Features on which a triangle, its edges and vertices agree are counted first, as whole numbers, and kept where the
/// count is not zero: over a flat surface one pair per point, so that nothing cancels in rounding. The counts of a
/// feature are complete if all triangles at the feature are among the candidates, whatever else is missing.
///
/// Rank-local. Positions `x` [m] are of the vertices of the surface.
#pragma once

#include "collision/candidates.hpp"
#include "collision/mollifier.hpp"
#include "collision/potential.hpp"

#include <array>
#include <span>
#include <vector>

namespace pliant {

/// A point of a triangle; with the area of its triangle times `weight`.
struct RulePoint {
  std::array<double, 3> barycentric{};
  double weight = 0.0;
};

/// Weights of one triangle: 3 corner_weight + sum of those of the inner points = 1; and of one segment, with as many
/// inner points: 2 end_weight + sum = 1. Their third barycentric coordinates are 0.
struct ContactRule {
  double corner_weight = 1.0 / 3.0;
  std::vector<RulePoint> inner_points;
  double end_weight = 1.0 / 2.0;
  std::vector<RulePoint> points_of_segment;
};

/// The corners with 1/20 each and three inner points with 17/60, exact for quadratic functions. The points are about
/// evenly spread: what they exert on the nodes of another mesh is the more uniform (two fifths of what the corners with
/// 1/12 and the centre with 3/4 leave of non-uniformity). On segments Lobatto's rule of five points, of degree 7.
ContactRule quadratic_contact_rule();

/// A point of a rule on [0, 1] and its weight.
struct LinePoint {
  double at = 0.0, weight = 0.0;
};
/// Lobatto's rule of five points, from one end to the other.
std::array<LinePoint, 5> lobatto_rule();

/// Which groups of triangles (SurfaceTriangle::group) may touch: a symmetric matrix by rows.
struct ContactSets {
  int num_sets = 1;
  std::vector<char> may_touch{1};

  bool operator()(int set, int other) const { return may_touch[num_sets * set + other] != 0; }
};

/// The same sets, where those that are left out (flags; empty: none is) touch nothing.
ContactSets without(ContactSets sets, std::span<const char> left_out);

/// The multiplicities m_e, m_v of edges and vertices for the points of each group, which see those of the triangles
/// that their group may touch.
class FeatureMultiplicities {
 public:
  FeatureMultiplicities() = default;
  FeatureMultiplicities(const CollisionSurface& surface, const ContactSets& sets);

  std::int32_t edge(std::int32_t group, std::int32_t edge) const { return edges_[group * num_edges_ + edge]; }
  std::int32_t vertex(std::int32_t group, std::int32_t vertex) const {
    return vertices_[group * num_vertices_ + vertex];
  }

 private:
  std::size_t num_edges_ = 0, num_vertices_ = 0;
  std::vector<std::int16_t> edges_, vertices_;  // of each group, one after another
};

/// A vertex (num_nodes 1) or a point inside a segment (2) or a triangle (3), as a point of the triangles of one group.
struct SurfacePoint {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  int num_nodes = 0;
  std::int32_t group = 0;
  double area = 0.0;  ///< A_p [m^2]

  Vector3<double> position(std::span<const Vector3<double>> x) const;
};

/// The vertices, in their order, and those of several groups once for each; then the inner points of the triangles and
/// segments in theirs. Those of zero weight are left out.
std::vector<SurfacePoint> surface_points(const CollisionSurface& surface, const ContactRule& rule);

/// Points (first) and triangles (second) within `distance` [m] whose nodes are not the same, sorted.
std::vector<BoxPair> point_candidates(const CollisionSurface& surface, std::span<const SurfacePoint> points,
                                      std::span<const Vector3<double>> x, double distance);

enum class FeatureKind : std::uint8_t { vertex, edge, face };

struct PointPair {
  std::int32_t point = 0, feature = 0;  ///< of the points; of the vertices, edges or triangles
  FeatureKind kind = FeatureKind::vertex;
  std::int32_t multiplicity = 0;  ///< not 0
  std::int8_t side = 0;           ///< 1 or -1: the distance counts as positive or negative; 0: it has no sign
  friend auto operator<=>(const PointPair&, const PointPair&) = default;
};

struct EdgePair {
  std::int32_t a = 0, b = 0;  ///< of the edges
  double weight = 0.0;        ///< [m^2]
  double threshold = 0.0;     ///< of the mollifier [m^4]
};

struct ContactPairs {
  std::vector<PointPair> points;  ///< sorted by point, feature
  std::vector<EdgePair> edges;    ///< in the order of their candidates
};

/// What is nearer than `reach` [m], of candidates within at least that distance.
std::vector<PointPair> point_pairs(const CollisionSurface& surface, const FeatureMultiplicities& multiplicities,
                                   std::span<const SurfacePoint> points, std::span<const BoxPair> candidates,
                                   std::span<const Vector3<double>> x, double reach);
std::vector<EdgePair> edge_pairs(const CollisionSurface& surface, std::span<const BoxPair> candidates,
                                 std::span<const Vector3<double>> x, double reach, double edge_share);

/// For laws that let surfaces pass into each other: of each point and each other body the nearest feature, where its
/// distance is at most `reach` in front of the surface, or `depth` behind it [m]. Which side it is says the triangle at
/// the feature that the point sees at the steepest angle; beyond the rim of an open surface there is no pair.
/// Candidates are within at least both distances.
std::vector<PointPair> nearest_pairs(const CollisionSurface& surface, const FeatureMultiplicities& multiplicities,
                                     std::span<const SurfacePoint> points, std::span<const BoxPair> candidates,
                                     std::span<const Vector3<double>> x, double reach, double depth);

/// Where the two features of a pair are closest.
struct PairGeometry {
  std::array<std::int32_t, 6> nodes{};  ///< vertices: of the point or edge, then of the other feature
  std::array<double, 6> weights{};      ///< r = sum of weights times positions, from the second feature to the first
  int num_nodes = 0, num_first_nodes = 0;
  double distance = 0.0;     ///< with its sign, if it has one [m]
  Vector3<double> normal{};  ///< r / distance
  double weight = 0.0;       ///< of the pair in the potential, mollifier included [m^2]
  std::int32_t body = 0, other = 0;
  std::int32_t first_vertex = 0;  ///< of the feature that stands for the pair where energies are counted
};

PairGeometry geometry_of(const CollisionSurface& surface, std::span<const SurfacePoint> points, const PointPair& pair,
                         std::span<const Vector3<double>> x);
PairGeometry geometry_of(const CollisionSurface& surface, const EdgePair& pair, std::span<const Vector3<double>> x);

/// How much of the potential's derivatives is wanted.
enum class ContactOrder { gradient, hessian, semidefinite_hessian };

// Evaluation. `law(body, body, d)` is a DistanceResponse. Returns W [J] and calls add_force(vertex, dW/dx) and
// add_block(vertex, vertex, d2W/dx dx), the latter where the order has it, for all vertices of all pairs, in their
// order.

template <class Law, class AddForce, class AddBlock>
double add_point_pairs(const CollisionSurface& surface, std::span<const SurfacePoint> points,
                       std::span<const PointPair> pairs, std::span<const Vector3<double>> x, const Law& law,
                       ContactOrder order, const AddForce& add_force, const AddBlock& add_block);
template <class Law, class AddForce, class AddBlock>
double add_edge_pairs(const CollisionSurface& surface, std::span<const EdgePair> pairs,
                      std::span<const Vector3<double>> x, const Law& law, ContactOrder order, const AddForce& add_force,
                      const AddBlock& add_block);

// ---------------------------------------------------------------------------------------------------------------------

/// The vertices of a pair's feature; the first is the one of the lowest key.
inline std::int32_t first_vertex(const CollisionSurface& surface, const PointPair& pair) {
  if (pair.kind == FeatureKind::face) return surface.triangles()[pair.feature].vertices[0];
  return pair.kind == FeatureKind::edge ? surface.edges()[pair.feature].vertices[0] : pair.feature;
}
inline std::int32_t body_of(const CollisionSurface& surface, const PointPair& pair) {
  return surface.vertices()[first_vertex(surface, pair)].body;
}

/// By which the distance of a pair is to be multiplied. On a face it follows from the normals, so that it holds at any
/// distance, 0 included.
template <int N>
double sign_of(const CollisionSurface& surface, const PointPair& pair, const Separation<N>& at,
               std::span<const Vector3<double>> x) {
  if (pair.side == 0) return 1.0;
  if (pair.kind != FeatureKind::face) return pair.side;
  const auto [a, b, c] = surface.triangles()[pair.feature].vertices;
  return dot(cross(x[b] - x[a], x[c] - x[a]), at.normal) < 0.0 ? -1.0 : 1.0;
}

/// One pair: `nodes` and where they are.
template <int N>
struct PairNodes {
  std::array<std::int32_t, N> nodes;
  std::array<Vector3<double>, N> x;
};

template <int N, class AddForce, class AddBlock>
void scatter(const Expansion<N>& U, double weight, const std::array<std::int32_t, N>& nodes, ContactOrder order,
             const AddForce& add_force, const AddBlock& add_block) {
  for (int i = 0; i < N; ++i) {
    add_force(nodes[i], weight * U.gradient[i]);
    if (order == ContactOrder::gradient) continue;
    for (int j = 0; j < N; ++j) add_block(nodes[i], nodes[j], weight * U.block(i, j));
  }
}

/// To second order, or to first. Where the Hessian is to be semidefinite a pair that is subtracted contributes none: a
/// bound from above.
template <int N, class Response>
Expansion<N> expand_to(ContactOrder order, const Separation<N>& at, const Response& response, bool is_subtracted) {
  if (order == ContactOrder::gradient) return first_order(at, response);
  if (order == ContactOrder::hessian) return expand(at, response, Definiteness::exact);
  if (!is_subtracted) return expand(at, response, Definiteness::semidefinite);
  return first_order(at, response);
}

/// The stencil of a point of A nodes and a feature of B, in A + B nodes.
template <int A, int B>
Stencil<A + B> point_feature_stencil(const std::array<double, 3>& weights, std::span<const Vector3<double>, 1 + B> x) {
  Stencil<1 + B> simple;
  if constexpr (B == 1) {
    simple = point_point_stencil();
  } else if constexpr (B == 2) {
    simple = stencil_of(closest_point_edge(x));
  } else {
    PointTriangle closest = closest_point_triangle(x);
    closest.feature = TriangleFeature::face;  // also of a point that lies on the face's rim, which has a normal then
    simple = stencil_of(closest);
  }
  Stencil<A + B> stencil;
  stencil.num_slopes = simple.num_slopes;
  for (int a = 0; a < A; ++a) stencil.weights[a] = weights[a];
  for (int b = 0; b < B; ++b) {
    stencil.weights[A + b] = simple.weights[1 + b];
    for (int k = 0; k < 2; ++k) stencil.slopes[k][A + b] = simple.slopes[k][1 + b];
  }
  return stencil;
}

template <class Law, class AddForce, class AddBlock>
double add_point_pairs(const CollisionSurface& surface, std::span<const SurfacePoint> points,
                       std::span<const PointPair> pairs, std::span<const Vector3<double>> x, const Law& law,
                       ContactOrder order, const AddForce& add_force, const AddBlock& add_block) {
  double total = 0.0;
  const auto add = [&]<int A, int B>(const PointPair& pair, const std::array<std::int32_t, B>& feature) {
    const SurfacePoint& point = points[pair.point];
    PairNodes<A + B> at;
    std::array<Vector3<double>, 1 + B> simple{point.position(x)};
    for (int a = 0; a < A; ++a) at.nodes[a] = point.nodes[a];
    for (int b = 0; b < B; ++b) {
      at.nodes[A + b] = feature[b];
      simple[1 + b] = x[feature[b]];
    }
    for (int n = 0; n < A + B; ++n) at.x[n] = x[at.nodes[n]];
    const auto closest = separation<A + B>(point_feature_stencil<A, B>(point.weights, simple), at.x);
    const double sign = sign_of(surface, pair, closest, x);
    auto response = law(surface.vertices()[point.nodes[0]].body, body_of(surface, pair), sign * closest.distance);
    response.pressure *= sign;  // -dU/dd of the distance without the sign
    const auto U = expand_to(order, closest, response, pair.multiplicity < 0);
    const double weight = 0.5 * point.area * pair.multiplicity;
    total += weight * U.value;
    scatter<A + B>(U, weight, at.nodes, order, add_force, add_block);
  };
  const auto add_of = [&]<int B>(const PointPair& pair, const std::array<std::int32_t, B>& feature) {
    switch (points[pair.point].num_nodes) {
      case 1:
        return add.template operator()<1, B>(pair, feature);
      case 2:
        return add.template operator()<2, B>(pair, feature);
      default:
        return add.template operator()<3, B>(pair, feature);
    }
  };
  for (const PointPair& pair : pairs) {
    switch (pair.kind) {
      case FeatureKind::vertex:
        add_of.template operator()<1>(pair, {pair.feature});
        break;
      case FeatureKind::edge:
        add_of.template operator()<2>(pair, surface.edges()[pair.feature].vertices);
        break;
      case FeatureKind::face:
        add_of.template operator()<3>(pair, surface.triangles()[pair.feature].vertices);
        break;
    }
  }
  return total;
}

template <class Law, class AddForce, class AddBlock>
double add_edge_pairs(const CollisionSurface& surface, std::span<const EdgePair> pairs,
                      std::span<const Vector3<double>> x, const Law& law, ContactOrder order, const AddForce& add_force,
                      const AddBlock& add_block) {
  double total = 0.0;
  for (const EdgePair& pair : pairs) {
    const auto &a = surface.edges()[pair.a].vertices, &b = surface.edges()[pair.b].vertices;
    const PairNodes<4> at{{a[0], a[1], b[0], b[1]}, {x[a[0]], x[a[1]], x[b[0]], x[b[1]]}};
    const double m = edge_edge_mollifier_value(at.x, pair.threshold);
    if (m == 0.0) continue;
    const auto closest = separation<4>(stencil_of(closest_edge_edge(at.x)), at.x);
    // The projection of a product is that of the whole.
    const bool is_mollified = m < 1.0;
    const ContactOrder inner =
        is_mollified && order == ContactOrder::semidefinite_hessian ? ContactOrder::hessian : order;
    const auto response = law(surface.edges()[pair.a].body, surface.edges()[pair.b].body, closest.distance);
    Expansion<4> U = expand_to(inner, closest, response, false);
    if (is_mollified) {
      U = product(edge_edge_mollifier(at.x, pair.threshold), U);
      if (order == ContactOrder::semidefinite_hessian) project_to_positive_semidefinite(U);
    }
    total += pair.weight * U.value;
    scatter<4>(U, pair.weight, at.nodes, order, add_force, add_block);
  }
  return total;
}

}  // namespace pliant
