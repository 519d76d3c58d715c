/// Distances to some triangles of a collision surface, however far: a tree of boxes around them.
///
/// Results do not depend on the numbers of vertices and triangles, which follow from the partition: where several
/// places are equally good up to rounding, the lowest along a generic direction wins. Rank-local.
#pragma once

#include "collision/closest_points.hpp"
#include "collision/surface.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace pliant {

/// Orders places; no two of a mesh are likely to be at the same level [m].
double level_of(const Vector3<double>& place);

class TriangleTree {
 public:
  /// A box in double precision, which is exact.
  struct Bounds {
    Vector3<double> low{}, high{};
  };
  /// A box around `count` triangles from `first` on; the first child of an inner node follows it.
  struct Node {
    Bounds bounds;
    std::int32_t first = 0, count = 0;
    std::int32_t second_child = 0;  ///< its place among the nodes; 0: a leaf
  };

  /// `numbers`: of triangles of the surface, at the positions `x` of its vertices [m], which outlive the object, as the
  /// surface does.
  TriangleTree(const CollisionSurface& surface, std::span<const Vector3<double>> x, std::vector<std::int32_t> numbers);

  const CollisionSurface& surface() const { return surface_; }
  std::span<const Vector3<double>> positions() const { return x_; }
  std::span<const std::int32_t> numbers() const { return numbers_; }  ///< in the order of the nodes
  std::span<const Node> nodes() const { return nodes_; }              ///< the root first; none without triangles

 private:
  void build(std::int32_t first, std::int32_t count);

  const CollisionSurface& surface_;
  std::span<const Vector3<double>> x_;
  std::vector<std::int32_t> numbers_;
  std::vector<Node> nodes_;
};

/// Where two surfaces are nearest to each other.
struct NearestPlaces {
  double distance = std::numeric_limits<double>::infinity();  ///< [m]; infinite: nothing within the distance
  Vector3<double> place{};                                    ///< a vertex there, or a point between two edges [m]
  std::int32_t body = 0, other = 0;
  bool is_vertex = false;
};

/// The least distance of the trees' triangles that `may_touch` accepts (by number) and that share no vertex, if it is
/// less than `within` [m]. Places of one body count if they have come to less than half of their distance at rest:
/// others are neighbours. Both trees are of one surface, at the same positions.
NearestPlaces nearest_places(const TriangleTree& a, const TriangleTree& b, double within,
                             const std::function<bool(std::int32_t, std::int32_t)>& may_touch);

/// The place on a surface that is nearest to a point.
struct Foot {
  std::int32_t triangle = -1;  ///< its number; -1: there are no triangles
  PointTriangle closest;
  Vector3<double> place{};   ///< [m]
  Vector3<double> normal{};  ///< of the face, the edge or the vertex there, outwards; not of unit length
  bool is_on_rim = false;    ///< of a surface that is not closed
};

/// The depth of points below the triangles of a tree.
class DepthBelow {
 public:
  /// The tree outlives the object.
  explicit DepthBelow(const TriangleTree& tree);
  Foot foot(const Vector3<double>& p) const;
  /// The same among the triangles that face a direction: their normals are at an obtuse angle to it, of more than 96
  /// degrees.
  Foot foot_facing(const Vector3<double>& direction, const Vector3<double>& p) const;
  /// The sum of the triangles' unit normals at an edge; at a vertex weighted by their angles.
  const Vector3<double>& normal_of_edge(std::int32_t edge) const { return normals_of_edges_[edge]; }
  const Vector3<double>& normal_of_vertex(std::int32_t vertex) const { return normals_of_vertices_[vertex]; }
  /// The distance to the nearest triangle if the point lies behind it [m]; 0 in front of it, or beyond the rim of a
  /// surface that is not closed. The sides are those of the normals around the nearest point, weighted by their angles
  /// (Baerentzen & Aanaes 2005, Signed distance computation using the angle weighted pseudonormal).
  double operator()(const Vector3<double>& p) const;
  bool is_closed() const { return is_closed_; }

 private:
  template <class Counts>
  Foot nearest(const Vector3<double>& p, const Counts& counts) const;

  const TriangleTree& tree_;
  std::vector<Vector3<double>> normals_of_edges_, normals_of_vertices_;  // of the surface, not of unit length
  std::vector<char> is_rim_edge_, is_rim_vertex_;
  bool is_closed_ = true;
};

}  // namespace pliant
