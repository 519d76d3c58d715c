/// The surfaces of bodies that may touch: vertices, edges and triangles, how they hang together, and their sizes at
/// rest.
///
/// A segment of a rod is a triangle whose last two corners are one vertex: its only edge and its two vertices are what
/// may touch, and its area is its thickness times its length.
///
/// Vertices and triangles come with keys that do not depend on the partition; everything here is sorted by them, so
/// that the same surface has the same numbers, whatever the order in which it was given. Rank-local: what a rank sees.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// The name of a vertex over all ranks.
using VertexKey = std::int64_t;

struct SurfaceVertex {
  VertexKey key = 0;
  Vector3<double> X{};  ///< position at rest [m]
};

struct SurfaceTriangle {
  std::array<VertexKey, 3> vertices{};  ///< keys, counterclockwise seen from outside
  std::int32_t body = 0;                ///< which body it is of
  std::int32_t group = 0;               ///< which named surface it is of
  double thickness = 0.0;               ///< of a shell, both of whose sides are outside, or of a rod [m]; 0: of a solid
  std::int32_t rigid_part = 0;          ///< with which it moves as a rigid body, from 1; 0: it deforms
};

/// The order of a triangle's corners that does not depend on the one in which they are given: the least first, in the
/// same sense of rotation; of a segment the greater twice.
std::array<std::int32_t, 3> in_lasting_order(std::array<std::int32_t, 3> corners);

class CollisionSurface {
 public:
  struct Vertex {
    VertexKey key = 0;
    std::int32_t body = 0;
    double area = 0.0;  ///< a third of that of its triangles, half of that of its segments [m^2]
  };
  struct Edge {
    std::array<std::int32_t, 2> vertices{};  ///< in the order of their keys
    std::int32_t body = 0;
    double area = 0.0;      ///< a third of that of its triangles, all of that of its segment [m^2]
    bool is_loose = false;  ///< of segments only
    bool is_flat = false;   ///< inside a plane face of a rigid part
  };
  struct Triangle {
    std::array<std::int32_t, 3> vertices{};  ///< the one of the least key first, in the order given
    std::array<std::int32_t, 3> edges{};     ///< edge k runs from vertex k to the next
    std::int32_t body = 0, group = 0;
    std::int32_t rigid_part = 0;
    double area = 0.0;       ///< [m^2]
    double thickness = 0.0;  ///< of a shell or a rod [m]; 0: of a solid

    bool is_segment() const { return vertices[1] == vertices[2]; }
    bool is_thin() const { return thickness > 0.0; }  ///< it bounds nothing: both of its sides are outside
    /// The vertices, each once, and the edges.
    std::span<const std::int32_t> corners() const { return std::span(vertices).first(is_segment() ? 2 : 3); }
    std::span<const std::int32_t> sides() const { return std::span(edges).first(is_segment() ? 1 : 3); }
  };

  CollisionSurface() = default;
  /// Throws std::invalid_argument where a triangle names a vertex that is not there, or one twice and is not a segment
  /// with a thickness, or where a key occurs twice. Vertices of no triangle are left out; so are segments between two
  /// vertices that have one already.
  CollisionSurface(std::span<const SurfaceVertex> vertices, std::span<const SurfaceTriangle> triangles);

  std::span<const Vertex> vertices() const { return vertices_; }  ///< sorted by keys
  std::span<const Edge> edges() const { return edges_; }          ///< sorted by the keys of their vertices
  std::span<const Triangle> triangles() const { return triangles_; }
  std::span<const Vector3<double>> rest_positions() const { return rest_positions_; }  ///< of the vertices [m]

  /// Whether they share a vertex: such never collide.
  bool is_incident(const Triangle& triangle, std::int32_t vertex) const;
  bool is_incident(const Edge& edge, const Edge& other) const;
  bool is_incident(const Triangle& triangle, const Triangle& other) const;

  double longest_edge() const { return longest_edge_; }  ///< at rest [m]

 private:
  /// Sets the edges, and those of the triangles.
  void number_edges();
  void mark_flat_edges();

  std::vector<Vertex> vertices_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
  std::vector<Vector3<double>> rest_positions_;
  double longest_edge_ = 0.0;
};

}  // namespace pliant
