/// How far points may go along their displacements before two features touch: continuous collision detection by
/// conservative advancement.
///
/// The bound of additive CCD (Li, Kaufman, Jiang 2021, Codimensional Incremental Potential Contact, section 5), made
/// sharper along the normal (Mirtich 1996): for any unit vector n, the distance of the convex hulls of points a_i and
/// b_j is at least min_ij n.(a_i - b_j). With n from the present closest points, which stays or turns with the lines
/// and planes that they lie on, and linear motion each of these is quadratic in time, so that the time until which all
/// of them stay above what is to be kept is known at once; there n is taken anew. With n at rest a step would be about
/// as long as the gap g for edges of length L that turn, with n that turns it is sqrt(g L). Every time that is reached
/// is certified by these inequalities, with a bound for their rounding: how the closest points were found, how
/// degenerate the features are and when one stops decides how far one gets, never whether it is safe.
#pragma once

#include "base/vector3.hpp"

#include <span>

namespace pliant {

/// How near two features may come.
struct Clearance {
  double least = 0.0;  ///< xi >= 0: distance that must be kept [m]
  double kept = 0.1;   ///< part of (distance - xi) that stays at the least; up to twice it may stay
};

/// alpha in (0, 1]: at x + t dx, for all 0 <= t <= alpha, the distance is at least xi + kept (d(0) - xi), to the
/// rounding of the positions. 1 if the whole displacement is free. 0 if the distance of the features does not exceed xi
/// to begin with, or only by rounding. `x` and `dx` [m]: the point, then the triangle.
double max_step_point_triangle(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                               const Clearance& clearance);
/// The first edge, then the second.
double max_step_edge_edge(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                          const Clearance& clearance);

/// alpha in (0, 1]: so far may a point go that comes through the triangle from its front, to which the normal of its
/// order points, until it is `depth` > 0 [m] behind it. 1 if it does not come through, or begins behind it. The path
/// beyond the triangle, which is within `least` [m] of it, is taken to first order.
double max_step_into_triangle(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                              double least, double depth);

}  // namespace pliant
