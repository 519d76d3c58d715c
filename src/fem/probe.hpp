/// Points of the reference body at which histories are recorded.
#pragma once

#include "fem/layout.hpp"

#include <array>
#include <span>
#include <vector>

namespace pliant {

/// A point as weights of nodes. One rank holds it; the nodes are empty on the others.
struct ProbeLocation {
  std::vector<PetscInt> nodes;  ///< local nodes
  std::vector<double> weights;  ///< shape functions at the point
  PetscInt cell = -1;           ///< local cell that contains the point, or has the nearest node; -1 on the other ranks
  double distance =
      0.0;  ///< from the wanted point to the one found [m]; > 0 if it lies outside the mesh. The same on every rank

  /// Interpolated xyz of an array over local nodes; zero on ranks that do not hold the point.
  std::array<double, 3> interpolate(std::span<const double> local) const;
};

/// Locates the points (the same on every rank) in the mesh, in the cell with the lowest number in the whole mesh among
/// those that contain it; a point outside gets the nearest node. The same on any number of ranks. `is_left_out`: per
/// local cell; empty: none is. Collective.
std::vector<ProbeLocation> locate(const NodeLayout& layout, std::span<const std::array<double, 3>> points,
                                  std::span<const char> is_left_out = {});

/// The point of the mesh, with flat sides of cells, nearest to a point outside it.
struct NearestOfMesh {
  std::array<double, 3> point{};
  double distance = 0.0;  ///< [m]
};

/// For points outside the mesh. `is_left_out`: as in `locate`. Collective.
NearestOfMesh nearest_of_mesh(const NodeLayout& layout, const std::array<double, 3>& X,
                              std::span<const char> is_left_out = {});

inline ProbeLocation locate(const NodeLayout& layout, const std::array<double, 3>& X) {
  return locate(layout, std::span(&X, 1)).front();
}

}  // namespace pliant
