/// Points of a penalty with the facets that are about as close to them as the nearest one.
#pragma once

#include "collision/contact_pairs.hpp"

namespace pliant {

/// What has a share of a point's area.
struct SharedPair {
  PointPair pair;
  double share = 1.0;  ///< of the area; the shares of a point and a body add up to 1
};

/// The nearest pairs with shares that change with no jump where the nearest place goes from one facet to another, as
/// for points below a ridge: facets next to it that are about as near have a share, the smaller the farther they are
/// and the nearer their foot is to their rim. What follows from normals, as friction does, is then continuous. Sorted
/// as `nearest`, of which the candidates are those. Without candidates every share is 1.
std::vector<SharedPair> shared_pairs(const CollisionSurface& surface, std::span<const SurfacePoint> points,
                                     std::span<const PointPair> nearest, std::span<const BoxPair> candidates,
                                     std::span<const Vector3<double>> x);

}  // namespace pliant
