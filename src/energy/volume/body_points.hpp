/// The positions of the quadrature points of a body, and values given point by point.
#pragma once

#include "fem/cells.hpp"

#include <array>
#include <vector>

namespace pliant {

/// A pack of points; padding lanes repeat the first one's cell.
struct PackPlaces {
  std::array<PetscInt, pack_size> cell;            ///< local cells
  std::array<std::array<double, 3>, pack_size> X;  ///< reference positions [m]
};

/// The body's points on this rank, in the order of CellPoint::index.
template <int Order>
std::vector<PackPlaces> places_of_points(const NodeLayout& layout, const CellGroups<Order>& groups, int body);

/// One value for all packs of points, or one for each.
template <class V>
struct PerPoint {
  std::vector<V> values;
  const V& operator[](std::size_t n) const { return values[values.size() == 1 ? 0 : n]; }
};

}  // namespace pliant
