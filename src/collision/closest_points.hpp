/// The closest points of a point and an edge, a point and a triangle, and two edges, and the features they lie on
/// (Ericson 2005, Real-Time Collision Detection, sections 5.1.2, 5.1.5, 5.1.9). Pure functions; lengths in metres.
///
/// The answer is the candidate with the least distance among the vertices, the feet on edges and, where it lies inside,
/// the foot on the face or on both lines. A classification that rounding gets wrong, in slivers, for edges that are
/// nearly parallel or of no length, therefore costs a rounding of the distance and no more.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace pliant {

enum class EdgeFeature : std::uint8_t { vertex_0, vertex_1, inside };
enum class TriangleFeature : std::uint8_t { vertex_0, vertex_1, vertex_2, edge_01, edge_12, edge_20, face };

/// On an edge from x0 to x1 the closest point is (1 - s) x0 + s x1.
struct PointEdge {
  EdgeFeature feature = EdgeFeature::vertex_0;
  double s = 0.0;                 ///< in [0, 1]; exactly 0 or 1 at a vertex
  double squared_distance = 0.0;  ///< [m^2]
};

struct PointTriangle {
  TriangleFeature feature = TriangleFeature::vertex_0;
  std::array<double, 3> barycentric{};  ///< of the closest point; exactly 0 for vertices outside of the feature
  double squared_distance = 0.0;        ///< [m^2]
};

/// Nine cases: a feature of either edge.
struct EdgeEdge {
  EdgeFeature a = EdgeFeature::vertex_0, b = EdgeFeature::vertex_0;
  double s = 0.0, t = 0.0;        ///< the closest points are a0 + s (a1 - a0) and b0 + t (b1 - b0)
  double squared_distance = 0.0;  ///< [m^2]
};

/// `x`: the point, then the edge.
PointEdge closest_point_edge(std::span<const Vector3<double>, 3> x);
/// `x`: the point, then the triangle.
PointTriangle closest_point_triangle(std::span<const Vector3<double>, 4> x);
/// `x`: the edge a, then the edge b.
EdgeEdge closest_edge_edge(std::span<const Vector3<double>, 4> x);

}  // namespace pliant
