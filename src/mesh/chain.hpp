/// Points along a physical curve of the mesh, of a tendon or a rod.
#pragma once

#include "mesh/mesh.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// An open chain of edges, or why they are none.
struct Chain {
  std::vector<std::array<double, 3>> points;
  bool is_directed = true;  ///< the edges all point from the first point to the last; else the order is arbitrary
  std::string fault;        ///< in words, with what to do; empty: none
};

/// Puts edges, at least one, in their order. Ends are one point if they are equal. `what`: what follows them, for the
/// fault, such as: a tendon.
Chain chain_of(std::span<const MeshCurve::Edge> edges, const std::string& what);

/// Each part between neighbours in 2^times.
std::vector<std::array<double, 3>> halved(std::vector<std::array<double, 3>> points, int times);

}  // namespace pliant
