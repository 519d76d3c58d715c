/// The stiffness matrices of packed cells, and adding them to the global matrix.
#pragma once

#include "fem/cells.hpp"
#include "material/law.hpp"

#include <algorithm>
#include <span>

namespace pliant {

/// The upper triangle of node blocks (a <= b) of a batch's symmetric matrices.
template <int N>
struct CellMatrix {
  std::array<Tensor3<Pack>, N*(N + 1) / 2> blocks;

  static constexpr int index(int a, int b) { return a * N - a * (a - 1) / 2 + (b - a); }  // a <= b
  PLIANT_INLINE Tensor3<Pack>& block(int a, int b) { return blocks[static_cast<std::size_t>(index(a, b))]; }
  PLIANT_INLINE const Tensor3<Pack>& block(int a, int b) const { return blocks[static_cast<std::size_t>(index(a, b))]; }
};

/// Contribution of a quadrature point to linear tetrahedra [N/m]: blocks between the barycentric coordinates l,
///   D_km = weight grad l_k . A . grad l_m,   (D_km)_ij = weight A_iJjL dl_k/dX_J dl_m/dX_L.
/// The contributions to elements of any order are combinations of these ten.
using LinearMatrix = CellMatrix<4>;

/// `A`: the symmetric tangent dP/dF [Pa]; `weight`: the volume of the point [m^3].
PLIANT_INLINE void set_linear_matrix(const Tangent<Pack>& A, const Tensor3<Pack>& inverse_jacobian, const Pack& weight,
                                     LinearMatrix& D) {
  // The gradients of l_1, l_2, l_3 are the rows of dxi/dX.
  for (int m = 0; m < 3; ++m) {
    for (int j = 0; j < 3; ++j) {
      std::array<Pack, 9> column;  // weight A_iJjL dl/dX_L at [3 i + J]
      for (int p = 0; p < 9; ++p) {
        const Pack* row = A.data() + 9 * p + 3 * j;
        column[p] = weight * (row[0] * inverse_jacobian(m, 0) + row[1] * inverse_jacobian(m, 1) +
                              row[2] * inverse_jacobian(m, 2));
      }
      for (int k = 0; k <= m; ++k) {
        for (int i = 0; i < 3; ++i) {
          D.block(k + 1, m + 1)(i, j) = column[3 * i] * inverse_jacobian(k, 0) +
                                        column[3 * i + 1] * inverse_jacobian(k, 1) +
                                        column[3 * i + 2] * inverse_jacobian(k, 2);
        }
      }
    }
  }
  // All four sum to zero.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      D.block(0, 1)(i, j) = -(D.block(1, 1)(i, j) + D.block(1, 2)(j, i) + D.block(1, 3)(j, i));
      D.block(0, 2)(i, j) = -(D.block(1, 2)(i, j) + D.block(2, 2)(i, j) + D.block(2, 3)(j, i));
      D.block(0, 3)(i, j) = -(D.block(1, 3)(i, j) + D.block(2, 3)(i, j) + D.block(3, 3)(i, j));
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      D.block(0, 0)(i, j) = -(D.block(0, 1)(j, i) + D.block(0, 2)(j, i) + D.block(0, 3)(j, i));
    }
  }
}

/// K_ab = sum over the points of dN_a/dl_k D_km dN_b/dl_m. A node of a quadratic element depends on two of the four
/// coordinates at most: half the products of dN_a/dX . A . dN_b/dX, and each block stays in registers over all points.
template <int Order>
void set_cell_matrix(const CellGroup<Order>& group, std::span<const LinearMatrix> points,
                     CellMatrix<Tet<Order>::num_nodes>& K) {
  using Element = Tet<Order>;
  unroll<Element::num_nodes>([&](auto a) __attribute__((always_inline)) {
    unroll<Element::num_nodes>([&](auto b) __attribute__((always_inline)) {
      if constexpr (a <= b) {
        Tensor3<Pack> total{};
        for (std::size_t q = 0; q < points.size(); ++q) {
          const auto& dN = group.barycentric_gradients[q];
          unroll<4>([&](auto k) __attribute__((always_inline)) {
            unroll<4>([&](auto m) __attribute__((always_inline)) {
              if constexpr (Element::depends(a, k) && Element::depends(b, m)) {
                const double factor = dN[a][k] * dN[b][m];
                const Tensor3<Pack>& D = points[q].block(std::min<int>(k, m), std::max<int>(k, m));
                total = total + factor * (k <= m ? D : transpose(D));
              }
            });
          });
        }
        K.block(a, b) = total;
      }
    });
  });
}

/// Adds rows of owned nodes of the real lanes.
template <int Order>
void scatter_add(const CellGroup<Order>& group, std::size_t batch_number, PetscInt num_owned_nodes,
                 const CellMatrix<CellGroup<Order>::num_nodes>& matrix, const BlockWriter& K) {
  constexpr int n = CellGroup<Order>::num_nodes;
  const auto& batch = group.batches[batch_number];
  const auto* blocks = group.blocks.data() + batch_number * n * n;
  for (int a = 0; a < n; ++a) {
    alignas(64) double x[n][9][pack_size];
    for (int b = 0; b < n; ++b) {
      const Tensor3<Pack> block = a <= b ? matrix.block(a, b) : transpose(matrix.block(b, a));
      for (int p = 0; p < 9; ++p) block.a[p].copy_to(x[b][p], std::experimental::vector_aligned);
    }
    // Row by row: the blocks of a row are next to each other.
    for (int lane = 0; lane < batch.num_lanes; ++lane) {
      const PetscInt node = batch.nodes[a][lane];
      if (node >= num_owned_nodes) continue;
      const BlockWriter::Row row = K.row(node);
      for (int b = 0; b < n; ++b) {
        const auto [values, stride] = row.block(blocks[a * n + b][lane]);
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) values[i * stride + j] += x[b][3 * i + j][lane];
        }
      }
    }
  }
}

}  // namespace pliant
