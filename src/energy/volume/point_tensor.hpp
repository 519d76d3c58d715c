/// Symmetric tensors (xx yy zz xy yz xz) and single numbers at the quadrature points of a body, among the internal
/// variables of a term: cell by cell in the order of the groups, ghost cells included.
#pragma once

#include "energy/term.hpp"
#include "energy/volume/body_cells.hpp"

namespace pliant {

inline constexpr std::array<int, num_symmetric> symmetric_rows{0, 1, 2, 0, 1, 0}, symmetric_columns{0, 1, 2, 1, 2, 2};

/// Index of a lane's point among those of the body on this rank.
template <int Order>
std::size_t number_of_point(const CellPoint<Order>& point, int lane) {
  return point.in.cell(lane) * point.in.group.rule.size() + point.number;
}

template <int Order>
std::size_t first_component(const CellPoint<Order>& point, int lane) {
  return num_symmetric * number_of_point(point, lane);
}

/// The places of all points; `number`: the index among what the term has at each point.
template <int Order>
void place_points(const BodyCells<Order>& cells, int number, std::span<InternalPlace> places) {
  cells.for_each_batch([&](const CellBatch<Order>& batch) {
    for (int k = 0; k < batch.group.rule.size(); ++k) {
      const CellPoint<Order> point{batch, k};
      for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
        places[number_of_point(point, lane)] = {batch.local_cell(lane), batch.group.rule.points[k], number};
      }
    }
  });
}

template <int Order>
PLIANT_INLINE Pack load_number(const CellPoint<Order>& point, std::span<const double> z) {
  return Pack([&](auto lane) { return z[number_of_point(point, lane)]; });
}

template <int Order>
PLIANT_INLINE void store_number(const CellPoint<Order>& point, const Pack& value, std::span<double> z) {
  for (int lane = 0; lane < point.in.batch().num_lanes; ++lane) z[number_of_point(point, lane)] = value[lane];
}

template <int Order>
PLIANT_INLINE Tensor3<Pack> load_symmetric(const CellPoint<Order>& point, std::span<const double> z) {
  Tensor3<Pack> G;
  for (int lane = 0; lane < pack_size; ++lane) {
    const double* p = z.data() + first_component(point, lane);
    for (int k = 0; k < num_symmetric; ++k) {
      G(symmetric_rows[k], symmetric_columns[k])[lane] = p[k];
      G(symmetric_columns[k], symmetric_rows[k])[lane] = p[k];
    }
  }
  return G;
}

template <int Order>
PLIANT_INLINE void store_symmetric(const CellPoint<Order>& point, const Tensor3<Pack>& G, std::span<double> z) {
  for (int lane = 0; lane < point.in.batch().num_lanes; ++lane) {
    double* p = z.data() + first_component(point, lane);
    for (int k = 0; k < num_symmetric; ++k) p[k] = G(symmetric_rows[k], symmetric_columns[k])[lane];
  }
}

/// The multiplier of a symmetric tensor whose components have the multipliers z: Z : dG = sum of z_k dG_k.
template <int Order>
PLIANT_INLINE Tensor3<Pack> load_multiplier(const CellPoint<Order>& point, std::span<const double> z) {
  Tensor3<Pack> Z = load_symmetric(point, z);
  for (int k = 3; k < num_symmetric; ++k) {
    Z(symmetric_rows[k], symmetric_columns[k]) *= 0.5;
    Z(symmetric_columns[k], symmetric_rows[k]) *= 0.5;
  }
  return Z;
}

/// z += the multipliers of the components of a symmetric tensor with the multiplier Z, which need not be symmetric.
template <int Order>
PLIANT_INLINE void add_multiplier(const CellPoint<Order>& point, const Tensor3<Pack>& Z, std::span<double> z) {
  for (int lane = 0; lane < point.in.batch().num_lanes; ++lane) {
    double* p = z.data() + first_component(point, lane);
    for (int k = 0; k < num_symmetric; ++k) {
      const int i = symmetric_rows[k], j = symmetric_columns[k];
      p[k] += i == j ? Z(i, i)[lane] : Z(i, j)[lane] + Z(j, i)[lane];
    }
  }
}

}  // namespace pliant
