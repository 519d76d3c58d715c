#include "collision/closest_points.hpp"

#include "base/limits.hpp"

#include <algorithm>

namespace pliant {
namespace {

using Vector = Vector3<double>;

/// Squared sine of an angle below which a normal has lost so many digits that its foot must compare with the others.
constexpr double few_digits_left = 1e-8;

/// The same for the point r and the edge from 0 to e.
PLIANT_INLINE PointEdge closest_on_edge(const Vector& r, const Vector& e) {
  const double along = dot(r, e), length2 = dot(e, e);
  if (along <= 0.0) return {EdgeFeature::vertex_0, 0.0, dot(r, r)};
  const Vector beyond = r - e;
  if (along >= length2) return {EdgeFeature::vertex_1, 1.0, dot(beyond, beyond)};
  const double s = along / length2;
  const Vector off = r - s * e;
  return {EdgeFeature::inside, s, dot(off, off)};
}

/// Edge k of a triangle runs from vertex k to the next.
PointTriangle on_triangle(int k, const PointEdge& foot) {
  const int next = (k + 1) % 3;
  PointTriangle closest{.squared_distance = foot.squared_distance};
  if (foot.feature == EdgeFeature::inside) {
    closest.feature = static_cast<TriangleFeature>(3 + k);
    closest.barycentric[k] = 1.0 - foot.s;
    closest.barycentric[next] = foot.s;
  } else {
    const int vertex = foot.feature == EdgeFeature::vertex_0 ? k : next;
    closest.feature = static_cast<TriangleFeature>(vertex);
    closest.barycentric[vertex] = 1.0;
  }
  return closest;
}

}  // namespace

PointEdge closest_point_edge(std::span<const Vector, 3> x) {
  return closest_on_edge(x[0] - x[1], x[2] - x[1]);
}

PointTriangle closest_point_triangle(std::span<const Vector, 4> x) {
  const Vector e01 = x[2] - x[1], e12 = x[3] - x[2], e20 = x[1] - x[3];
  const Vector r0 = x[0] - x[1], r1 = x[0] - x[2], r2 = x[0] - x[3];
  const Vector normal = cross(e01, e12);
  // Areas of the triangles that the foot makes with the edges, times the same number.
  const double l2 = dot(normal, cross(e01, r0)), l0 = dot(normal, cross(e12, r1)), l1 = dot(normal, cross(e20, r2));
  PointTriangle closest{.squared_distance = infinity};
  if (l0 > 0.0 && l1 > 0.0 && l2 > 0.0) {
    const double scale = 1.0 / (l0 + l1 + l2);
    const Vector off = (scale * l0) * r0 + (scale * l1) * r1 + (scale * l2) * r2;
    closest = {TriangleFeature::face, {scale * l0, scale * l1, scale * l2}, dot(off, off)};
    const double longest2 = std::max({dot(e01, e01), dot(e12, e12), dot(e20, e20)});
    if (dot(normal, normal) > few_digits_left * longest2 * longest2) return closest;
  }
  const std::array<PointEdge, 3> feet{closest_on_edge(r0, e01), closest_on_edge(r1, e12), closest_on_edge(r2, e20)};
  for (int k = 0; k < 3; ++k) {
    if (feet[k].squared_distance < closest.squared_distance) closest = on_triangle(k, feet[k]);
  }
  return closest;
}

EdgeEdge closest_edge_edge(std::span<const Vector, 4> x) {
  const Vector u = x[1] - x[0], v = x[3] - x[2], r = x[0] - x[2];
  const Vector normal = cross(u, v);
  const double n2 = dot(normal, normal);
  // a0 + s u - (b0 + t v) is along the normal
  const double s = dot(cross(v, r), normal), t = dot(cross(u, r), normal);
  EdgeEdge closest{.squared_distance = infinity};
  if (s > 0.0 && s < n2 && t > 0.0 && t < n2) {
    const Vector off = r + (s / n2) * u - (t / n2) * v;
    closest = {EdgeFeature::inside, EdgeFeature::inside, s / n2, t / n2, dot(off, off)};
    if (n2 > few_digits_left * dot(u, u) * dot(v, v)) return closest;
  }
  // Between parallel edges all of that is rounding: the insides have to be clearly nearer than every vertex.
  double least = (1.0 + few_digits_left) * closest.squared_distance;
  const auto offer = [&](EdgeFeature a, EdgeFeature b, double at_a, double at_b, double squared_distance) {
    if (!(squared_distance < least)) return;
    closest = {a, b, at_a, at_b, squared_distance};
    least = squared_distance;
  };
  const PointEdge a0 = closest_on_edge(r, v), a1 = closest_on_edge(x[1] - x[2], v);
  const PointEdge b0 = closest_on_edge(-1.0 * r, u), b1 = closest_on_edge(x[3] - x[0], u);
  offer(EdgeFeature::vertex_0, a0.feature, 0.0, a0.s, a0.squared_distance);
  offer(EdgeFeature::vertex_1, a1.feature, 1.0, a1.s, a1.squared_distance);
  offer(b0.feature, EdgeFeature::vertex_0, b0.s, 0.0, b0.squared_distance);
  offer(b1.feature, EdgeFeature::vertex_1, b1.s, 1.0, b1.squared_distance);
  return closest;
}

}  // namespace pliant
