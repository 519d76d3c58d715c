/// How close surfaces come to obstacles, and whether they pass through them from one state to the next.
#pragma once

#include "energy/contact/contact_surface.hpp"

#include <limits>
#include <optional>

namespace pliant {

/// A contact gap, over the points and nodes of the owned facets.
struct Closeness {
  double gap = std::numeric_limits<double>::infinity();  ///< the least distance to the threshold [m]; negative if the
                                                         ///< point is within it
  double num_points = 0.0;                               ///< contact points on which a pressure acts
};
Closeness closeness(const ContactSurface& surface, const ObstacleFrame& obstacle, std::span<const double> q);

/// A point of a surface that the obstacle does not push back to the side from which it came.
struct Passage {
  double depth = 0.0;       ///< greatest depth on its path [m]
  Vector3<double> place{};  ///< the end of its path
};

/// The straight path of a point relative to the solid. It passes if it enters the solid, or starts in it, where the
/// normal is opposite to that at its exit or end (negative dot product); or if it ends so deep that a point half as
/// deep again is less deep: beyond 2/5 of the local thickness.
std::optional<Passage> passage(const SignedDistance& solid, const Vector3<double>& from, const Vector3<double>& to);

/// The two states between which surfaces are examined, relative to one obstacle.
struct ObstacleStep {
  const SignedDistance& shape;
  ObstacleFrame from, to;
  double width = std::numeric_limits<double>::infinity();  ///< of what could slip between the points [m]
};

/// The deepest passage of places on the owned facets that are less than a quarter of the obstacle's width apart (but no
/// more than 33 along an edge), and of their contact points.
std::optional<Passage> passage(const ContactSurface& surface, const ObstacleStep& step, std::span<const double> q_from,
                               std::span<const double> q_to);

}  // namespace pliant
