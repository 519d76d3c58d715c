/// Convex polygons in a plane, anticlockwise: areas, and what of them a triangle covers.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace pliant {

using PlanePoint = std::array<double, 2>;
using Polygon = std::vector<PlanePoint>;

/// Twice the area of the triangle a b c; negative if it is clockwise.
inline double doubled_area(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

inline double area(const Polygon& polygon) {
  double sum = 0.0;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    sum += 0.5 * doubled_area(polygon[0], polygon[k - 1], polygon[k]);
  }
  return sum;
}

/// Areas, and distances in units of the polygons' size, that are rounding.
inline constexpr double polygon_rounding = 1e-14;

/// The parts of a polygon to the left and to the right of the line from a to b (Sutherland & Hodgman 1974, Reentrant
/// polygon clipping). Corners on the line belong to both.
inline std::pair<Polygon, Polygon> split(const Polygon& polygon, const PlanePoint& a, const PlanePoint& b) {
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  const auto height = [&](const PlanePoint& x) {
    const double h = doubled_area(a, b, x) / length;
    return std::abs(h) < polygon_rounding ? 0.0 : h;
  };
  std::pair<Polygon, Polygon> parts;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const PlanePoint& x = polygon[k];
    const PlanePoint& y = polygon[(k + 1) % polygon.size()];
    const double from = height(x), to = height(y);
    if (from >= 0.0) parts.first.push_back(x);
    if (from <= 0.0) parts.second.push_back(x);
    if (from * to >= 0.0) continue;
    const double s = from / (from - to);
    const PlanePoint crossing{x[0] + s * (y[0] - x[0]), x[1] + s * (y[1] - x[1])};
    parts.first.push_back(crossing);
    parts.second.push_back(crossing);
  }
  return parts;
}

/// Moves what the anticlockwise triangle covers of `uncovered` to `covered`. The polygons are of size 1.
inline void cover(const std::array<PlanePoint, 3>& triangle, std::vector<Polygon>& uncovered,
                  std::vector<Polygon>& covered) {
  std::vector<Polygon> rest;
  for (Polygon& polygon : uncovered) {
    Polygon inside = polygon;
    std::vector<Polygon> outside;
    for (std::size_t k = 0; k < 3 && area(inside) > polygon_rounding; ++k) {
      auto [left, right] = split(inside, triangle[k], triangle[(k + 1) % 3]);
      inside = std::move(left);
      if (area(right) > polygon_rounding) outside.push_back(std::move(right));
    }
    if (area(inside) <= polygon_rounding) {
      rest.push_back(std::move(polygon));
      continue;
    }
    covered.push_back(std::move(inside));
    for (Polygon& part : outside) rest.push_back(std::move(part));
  }
  uncovered = std::move(rest);
}

}  // namespace pliant
