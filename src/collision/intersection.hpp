/// Whether segments and triangles meet, decided in exact arithmetic.
///
/// The signs of determinants are those of the coordinates as they are: computed in double precision with a bound of the
/// error (Shewchuk 1997, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates), and where
/// that does not decide, from the exact sum of all products. Exact unless products of three coordinates' differences,
/// or their roundings, leave the range of a double: for coordinates, where they are not 0, of 1e-70 to 1e70.
#pragma once

#include "base/vector3.hpp"

#include <array>

namespace pliant {

/// The sign of (b - a) x (c - a) . (d - a): 1, -1, or 0 where the four points lie in one plane.
int orientation(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c, const Vector3<double>& d);

/// Closed: to touch is to meet. A segment in the plane of the triangle meets it where it does so in that plane. For a
/// triangle without area the answer may be yes where their shadows on all planes of coordinates meet.
bool segment_meets_triangle(const std::array<Vector3<double>, 2>& segment,
                            const std::array<Vector3<double>, 3>& triangle);
bool triangles_meet(const std::array<Vector3<double>, 3>& a, const std::array<Vector3<double>, 3>& b);

}  // namespace pliant
