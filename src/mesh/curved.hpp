/// Measures of a second-order (curved) tetrahedron.
#pragma once

#include "mesh/serial_mesh.hpp"
#include "mesh/tetrahedron.hpp"

#include <array>

namespace pliant::tetrahedron {

/// Smallest determinant of the Jacobian of the map x(xi) = sum_i N_i(xi) x_i, relative to 6 V of the straight
/// tetrahedron, sampled at the corners, the edges' midpoints and the centre. If it is not positive, the element is
/// folded. `x`: corners, then the mid-edge nodes of `local_edges`.
inline double relative_jacobian(const std::array<Point, 10>& x) {
  using Barycentric = std::array<double, 4>;
  // N_i = l_i (2 l_i - 1) and N_ij = 4 l_i l_j in barycentric coordinates l, grad l_0 = -(1, 1, 1), grad l_k = e_k.
  const auto determinant = [&](const Barycentric& l) {
    std::array<Point, 4> by_l{};  // dx/dl_i, each l_i taken as independent
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t d = 0; d < 3; ++d) by_l[i][d] = (4.0 * l[i] - 1.0) * x[i][d];
    }
    for (std::size_t e = 0; e < 6; ++e) {
      const auto i = static_cast<std::size_t>(local_edges[e][0]), j = static_cast<std::size_t>(local_edges[e][1]);
      for (std::size_t d = 0; d < 3; ++d) {
        by_l[i][d] += 4.0 * l[j] * x[4 + e][d];
        by_l[j][d] += 4.0 * l[i] * x[4 + e][d];
      }
    }
    return dot(cross(by_l[1] - by_l[0], by_l[2] - by_l[0]), by_l[3] - by_l[0]);
  };
  double smallest = determinant({0.25, 0.25, 0.25, 0.25});
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i; j < 4; ++j) {
      Barycentric l{};
      l[i] += 0.5;
      l[j] += 0.5;
      smallest = std::min(smallest, determinant(l));
    }
  }
  return smallest / (6.0 * volume({x[0], x[1], x[2], x[3]}));
}

}  // namespace pliant::tetrahedron
