/// Broad phase of a surface: which vertices and triangles, and which edges, may be near one another.
#pragma once

#include "collision/bvh.hpp"
#include "collision/surface.hpp"
#include "collision/surface_neighbours.hpp"

#include <span>
#include <vector>

namespace pliant {

/// Pairs that share no vertex, sorted.
struct Candidates {
  std::vector<BoxPair> point_triangle;  ///< a vertex, a triangle
  std::vector<BoxPair> edge_edge;       ///< two edges, the first of the lower number
};

/// The trees over the vertices, edges and triangles of a surface, as they were when built and last refitted.
class BroadPhase {
 public:
  BroadPhase() = default;
  /// `x`, `y`: positions of the vertices [m], at both ends of a linear motion; the same where nothing moves. Pairs that
  /// come nearer than `distance` [m] on the way will be found.
  BroadPhase(const CollisionSurface& surface, std::span<const Vector3<double>> x, std::span<const Vector3<double>> y,
             double distance);
  /// Other positions of the same surface, with the order of the trees.
  void refit(const CollisionSurface& surface, std::span<const Vector3<double>> x, std::span<const Vector3<double>> y,
             double distance);

  /// All candidates, on a surface that is as it was.
  Candidates candidates(const CollisionSurface& surface) const;

 private:
  void set_boxes(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                 std::span<const Vector3<double>> y, double distance);

  std::vector<Box> vertex_boxes_, edge_boxes_, triangle_boxes_;
  Bvh vertices_, edges_, triangles_;
};

/// The same for positions at one time.
Candidates find_candidates(const CollisionSurface& surface, std::span<const Vector3<double>> x, double distance);

/// The least distances between parts of bodies that share no vertex and are not neighbours [m], and at most `distance`:
/// a symmetric matrix by rows of all bodies (SurfaceTriangle::body).
std::vector<double> least_distances(const CollisionSurface& surface, std::span<const Vector3<double>> x, int num_bodies,
                                    double distance, const SurfaceNeighbours& neighbours = {});

/// Pairs of triangles of different bodies whose boxes are nearer than `distance` [m], of those with these numbers, in
/// no particular order. `dx`: displacements [m], on the way along which they count as well; empty: none.
std::vector<BoxPair> triangles_of_bodies_near(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                                              std::span<const Vector3<double>> dx,
                                              std::span<const std::int32_t> numbers, double distance);

/// All edges (first) that meet a triangle (second) that they are not adjacent to, in exact arithmetic: empty if and
/// only if nothing passes through anything.
std::vector<BoxPair> find_intersections(const CollisionSurface& surface, std::span<const Vector3<double>> x);

}  // namespace pliant
