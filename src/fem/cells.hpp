/// The cells (elements) of one body in SIMD packs, over which the hot loops run. Built once.
#pragma once

#include "base/simd.hpp"
#include "base/tensor.hpp"
#include "fem/block_matrix.hpp"
#include "fem/element.hpp"
#include "fem/layout.hpp"
#include "fem/quadrature.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace pliant {

enum class CellShape { affine, curved };

/// `pack_size` cells at a time. Padding lanes repeat a real cell and have zero measure. Affine cells store their
/// geometry once, curved ones at every point of the quadrature rule.
template <int Order>
struct CellGroup {
  static constexpr int num_nodes = Tet<Order>::num_nodes;
  using ShapeGradients = std::array<std::array<double, 3>, num_nodes>;
  using BarycentricGradients = std::array<std::array<double, 4>, num_nodes>;

  struct Batch {
    std::array<std::array<PetscInt, pack_size>, num_nodes> nodes;  ///< local nodes
    int num_lanes;                                                 ///< real cells; the rest is padding
    Pack owned;                                                    ///< 1 where this rank owns the cell, else 0
  };

  int body = 0;
  CellShape shape = CellShape::affine;
  QuadratureRule<3> rule;
  std::vector<ShapeGradients> shape_gradients;              ///< dN_a/dxi at the rule's points
  std::vector<BarycentricGradients> barycentric_gradients;  ///< dN_a/dl, likewise
  std::vector<Batch> batches;
  std::vector<PetscInt> cells;                           ///< local cells, pack_size per batch (padding: -1)
  int geometry_points = 1;                               ///< 1 (affine) or the rule's points
  std::vector<Tensor3<Pack>> inverse_jacobian;           ///< dxi/dX, [batch * geometry_points + point] [1/m]
  std::vector<Tensor3<Pack>> centroid_inverse_jacobian;  ///< dxi/dX at the centroid of curved cells, per batch [1/m]
  std::vector<Pack> jacobian;                            ///< det dX/dxi, likewise [m^3]; 0 in padding lanes
  std::vector<std::array<std::int32_t, pack_size>>
      blocks;  ///< BlockPattern::block of nodes (a, b) at [(batch * n + a) * n + b]

  PLIANT_INLINE std::size_t geometry(std::size_t batch, int point) const {
    return batch * geometry_points + (geometry_points == 1 ? 0 : point);
  }

  PLIANT_INLINE const Tensor3<Pack>& inverse_jacobian_at_centroid(std::size_t batch) const {
    return shape == CellShape::affine ? inverse_jacobian[geometry(batch, 0)] : centroid_inverse_jacobian[batch];
  }

  /// dN_a/dxi at a point; a compile-time constant for linear elements.
  PLIANT_INLINE decltype(auto) gradients(int point) const {
    if constexpr (Order == 1) {
      return Tet<1>::gradients({});
    } else {
      return static_cast<const ShapeGradients&>(shape_gradients[point]);
    }
  }
};

/// All cells of the rank, grouped by body and shape; a group may be empty on a rank.
template <int Order>
using CellGroups = std::vector<CellGroup<Order>>;

/// `body_of_cell`: per local cell. `degree_of_body`: polynomial degree that the body's rule integrates exactly. Throws
/// InputError that names a cell whose Jacobian determinant is not positive. Not collective.
template <int Order>
CellGroups<Order> make_cell_groups(const NodeLayout& layout, const BlockPattern& pattern,
                                   const std::vector<int>& body_of_cell, const std::vector<int>& degree_of_body);

/// Three numbers per node of a batch.
template <int N>
using NodeValues = std::array<std::array<Pack, 3>, N>;

template <int Order>
PLIANT_INLINE NodeValues<Tet<Order>::num_nodes> gather(const typename CellGroup<Order>::Batch& batch,
                                                       const double* local) {
  NodeValues<Tet<Order>::num_nodes> u;
  for (int a = 0; a < Tet<Order>::num_nodes; ++a) {
    alignas(64) double x[3][pack_size];
    for (int lane = 0; lane < pack_size; ++lane) {
      const double* p = local + 3 * batch.nodes[a][lane];
      for (int k = 0; k < 3; ++k) x[k][lane] = p[k];
    }
    for (int k = 0; k < 3; ++k) u[a][k].copy_from(x[k], std::experimental::vector_aligned);
  }
  return u;
}

template <int Order>
PLIANT_INLINE void scatter_add(const typename CellGroup<Order>::Batch& batch,
                               const NodeValues<Tet<Order>::num_nodes>& f, double* local) {
  for (int a = 0; a < Tet<Order>::num_nodes; ++a) {
    alignas(64) double x[3][pack_size];
    for (int k = 0; k < 3; ++k) f[a][k].copy_to(x[k], std::experimental::vector_aligned);
    for (int lane = 0; lane < batch.num_lanes; ++lane) {
      double* p = local + 3 * batch.nodes[a][lane];
      for (int k = 0; k < 3; ++k) p[k] += x[k][lane];
    }
  }
}

/// grad u = sum_a u_a (x) dN_a/dxi . dxi/dX, from differences to the first node: large common displacements cancel
/// before they are multiplied.
template <int Order>
PLIANT_INLINE Tensor3<Pack> displacement_gradient(const NodeValues<Tet<Order>::num_nodes>& u,
                                                  const std::array<std::array<double, 3>, Tet<Order>::num_nodes>& dN,
                                                  const Tensor3<Pack>& inverse_jacobian) {
  Tensor3<Pack> reference{};
  for (int a = 1; a < Tet<Order>::num_nodes; ++a) {
    for (int i = 0; i < 3; ++i) {
      const Pack d = u[a][i] - u[0][i];
      for (int k = 0; k < 3; ++k) reference(i, k) += d * dN[a][k];
    }
  }
  return matmul(reference, inverse_jacobian);
}

}  // namespace pliant
