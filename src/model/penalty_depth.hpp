/// How deep bodies may be in each other where a penalty parts them.
#pragma once

#include "collision/overlaps.hpp"

#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// The part of the depth to which a penalty pushes bodies apart at which a step is rejected.
inline constexpr double too_deep = 0.8;

/// The depth to which a penalty pushes bodies apart: a part of `facet_size`, the smallest of a body, and of the
/// thickness of the thinnest body [m]. What is deeper is seldom nearest to the place through which it came.
double depth_of_penalty(const CollisionSurface& surface, std::size_t num_bodies, double facet_size);

/// The overlaps of different bodies that are too deep for a penalty which pushes to `depth` [m].
std::vector<SurfaceOverlap> deep_overlaps(const CollisionSurface& surface, std::span<const Vector3<double>> x,
                                          const ContactSets& sets, double depth);

/// The straight motion of all vertices, none of them farther than `farthest` [m].
struct SurfaceMotion {
  std::span<const Vector3<double>> from, to;
  double farthest = 0.0;
};

/// The first deep overlap at places of the motion so near each other that nothing passes between them, if there are at
/// most 64.
std::optional<SurfaceOverlap> deep_overlap_on_way(const CollisionSurface& surface, const SurfaceMotion& motion,
                                                  const ContactSets& sets, double depth);

}  // namespace pliant
