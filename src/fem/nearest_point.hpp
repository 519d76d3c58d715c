/// The point of a triangle nearest to a given point.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cstddef>

namespace pliant {

/// Where on a triangle the nearest point lies.
enum class Feature { face, edge, corner };

struct Nearest {
  Feature feature = Feature::face;
  std::size_t number = 0;  ///< of the corner, or of the edge that starts there, 0 to 2
  Vector3<double> point{};
};

/// The point of a triangle nearest to x: Ericson 2005, Real-Time Collision Detection, 5.1.5.
inline Nearest nearest_point(const std::array<Vector3<double>, 3>& triangle, const Vector3<double>& x) {
  const auto& [a, b, c] = triangle;
  const Vector3<double> ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx), d5 = dot(ab, cx),
               d6 = dot(ac, cx);
  if (d1 <= 0.0 && d2 <= 0.0) return {Feature::corner, 0, a};
  if (d3 >= 0.0 && d4 <= d3) return {Feature::corner, 1, b};
  if (d6 >= 0.0 && d5 <= d6) return {Feature::corner, 2, c};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {Feature::edge, 0, a + (d1 / (d1 - d3)) * ab};
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return {Feature::edge, 1, b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b)};
  }
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {Feature::edge, 2, a + (d2 / (d2 - d6)) * ac};
  return {Feature::face, 0, a + (vb / (va + vb + vc)) * ab + (vc / (va + vb + vc)) * ac};
}

}  // namespace pliant
