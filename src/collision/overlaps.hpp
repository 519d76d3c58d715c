/// Where the surfaces of bodies overlap, for messages and pictures: how many places, how deep. Rank-local.
#pragma once

#include "collision/contact_pairs.hpp"
#include "collision/surface.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// A triangle that passes through the surface of another body (or of its own), touches it, or lies below it.
struct OverlappingTriangle {
  std::int32_t number = 0;  ///< of the surface
  double depth = 0.0;       ///< of the deepest of seven points on it: corners, middles of the edges, centre [m]
};

/// What overlaps between two bodies that may touch.
struct SurfaceOverlap {
  std::int32_t body = 0, other = 0;            ///< body <= other
  std::vector<OverlappingTriangle> triangles;  ///< of both, in an order that does not depend on their numbers
  int num_places = 0;                          ///< parts of these triangles that hang together
  double depth = 0.0;       ///< the greatest of them; 0 where surfaces only touch, or of one body [m]
  Vector3<double> place{};  ///< where that is [m]
  bool is_thin = false;     ///< one of the bodies is a shell or a rod
};

/// All overlaps at positions `x` of triangles whose groups may touch, by body, then other. A body that lies wholly in
/// another one is found if the surface of the latter is closed. Whether triangles meet is decided exactly.
std::vector<SurfaceOverlap> find_overlaps(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                                          const ContactSets& sets);

}  // namespace pliant
