/// Adding the matrices of packed cells to the global matrix.
#pragma once

#include "fem/cells.hpp"

namespace pliant {

/// The upper triangle of node blocks (a <= b) of a batch's symmetric matrices.
template <int N>
struct CellMatrix {
  std::array<Tensor3<Pack>, N*(N + 1) / 2> blocks;
  static constexpr int index(int a, int b) { return a * N - a * (a - 1) / 2 + (b - a); }  // a <= b
};

/// Adds rows of owned nodes of the real lanes.
template <int Order>
void scatter_add(const CellGroup<Order>& group, std::size_t batch_number, PetscInt num_owned_nodes,
                 const CellMatrix<CellGroup<Order>::num_nodes>& matrix, const BlockWriter& K) {
  constexpr int n = CellGroup<Order>::num_nodes;
  const auto& batch = group.batches[batch_number];
  const auto* blocks = group.blocks.data() + batch_number * n * n;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      const bool upper = a <= b;
      const Tensor3<Pack>& m = matrix.blocks[upper ? matrix.index(a, b) : matrix.index(b, a)];
      alignas(64) double x[9][pack_size];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          (upper ? m(i, j) : m(j, i)).copy_to(x[3 * i + j], std::experimental::vector_aligned);
        }
      }
      for (int lane = 0; lane < batch.num_lanes; ++lane) {
        const PetscInt row = batch.nodes[a][lane];
        if (row >= num_owned_nodes) continue;
        const auto [values, stride] = K.block(row, blocks[a * n + b][lane]);
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) values[i * stride + j] += x[3 * i + j][lane];
        }
      }
    }
  }
}

}  // namespace pliant
