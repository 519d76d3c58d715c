/// Facets as flat triangles.
#pragma once

#include <array>
#include <span>

namespace pliant {

/// The corners of the triangles of a facet of three or six nodes, among its nodes (corners, then mid-edge nodes
/// 01 12 02).
inline std::span<const std::array<int, 3>> triangles_of_facet(int nodes_per_facet) {
  static constexpr std::array<std::array<int, 3>, 1> linear{{{0, 1, 2}}};
  static constexpr std::array<std::array<int, 3>, 4> quadratic{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
  if (nodes_per_facet == 3) return linear;
  return quadratic;
}

}  // namespace pliant
