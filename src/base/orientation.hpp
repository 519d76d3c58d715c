/// One orientation for triangles that are neighbours.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace pliant {

/// A part of a surface: triangles that are connected by edges of two triangles.
struct OrientedPart {
  std::vector<std::size_t> triangles;  ///< in the order in which they were found
  bool is_closed = true;               ///< every edge of them is one of two triangles
};

/// Swaps corners of triangles such that neighbours at edges of two have one orientation, where the surface has one; the
/// first of each part stays. Returns the parts, in the order of their first triangles.
template <class Node>
std::vector<OrientedPart> orient(std::vector<std::array<Node, 3>>& triangles) {
  std::map<std::pair<Node, Node>, std::vector<std::size_t>> at_edge;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      at_edge[std::minmax(triangles[t][k], triangles[t][(k + 1) % 3])].push_back(t);
    }
  }
  std::vector<OrientedPart> parts;
  std::vector<char> is_done(triangles.size(), 0);
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (is_done[first] != 0) continue;
    is_done[first] = 1;
    OrientedPart& part = parts.emplace_back(OrientedPart{{first}});
    for (std::size_t n = 0; n < part.triangles.size(); ++n) {
      const std::array<Node, 3> of = triangles[part.triangles[n]];
      for (std::size_t k = 0; k < 3; ++k) {
        const Node from = of[k], to = of[(k + 1) % 3];
        const auto& both = at_edge.at(std::minmax(from, to));
        part.is_closed = part.is_closed && both.size() == 2;
        if (both.size() != 2) continue;
        const std::size_t other = both[0] == part.triangles[n] ? both[1] : both[0];
        if (is_done[other] != 0) continue;
        std::array<Node, 3>& nodes = triangles[other];
        const auto at = static_cast<std::size_t>(std::ranges::find(nodes, from) - nodes.begin());
        if (nodes[(at + 1) % 3] == to) std::swap(nodes[1], nodes[2]);
        is_done[other] = 1;
        part.triangles.push_back(other);
      }
    }
  }
  return parts;
}

}  // namespace pliant
