/// Measures of a straight tetrahedron.
#pragma once

#include "base/vector3.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant::tetrahedron {

using Point = Vector3<double>;         ///< [m]
using Corners = std::array<Point, 4>;  ///< x0 .. x3 of a tetrahedron

/// Signed volume det(x1 - x0, x2 - x0, x3 - x0) / 6 [m^3].
inline double volume(const Corners& x) {
  return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6.0;
}

/// Squared lengths of the six edges [m^2].
inline std::array<double, 6> squared_edges(const Corners& x) {
  std::array<double, 6> l2{};
  std::size_t e = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const Point d = x[j] - x[i];
      l2[e++] = dot(d, d);
    }
  }
  return l2;
}

inline double longest_edge(const Corners& x) {
  const auto l2 = squared_edges(x);
  return std::sqrt(*std::max_element(l2.begin(), l2.end()));
}

/// Mean-ratio quality q = 12 (3 V)^(2/3) / sum l^2: 1 for the regular tetrahedron, 0 for a flat or inverted one
/// (Liu & Joe 1994, "Relationship between tetrahedron shape measures", BIT 34, eta).
inline double mean_ratio(const Corners& x) {
  const auto l2 = squared_edges(x);
  double sum = 0.0;
  for (const double l : l2) sum += l;
  return sum > 0.0 ? 12.0 * std::cbrt(std::pow(std::max(3.0 * volume(x), 0.0), 2)) / sum : 0.0;
}

}  // namespace pliant::tetrahedron
