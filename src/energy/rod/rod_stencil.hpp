/// Stencils of rods: variables that depend linearly on the positions of a few nodes.
#pragma once

#include "fem/block_matrix.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <eigen3/Eigen/Eigenvalues>
#include <span>

namespace pliant {

/// The nearest matrix without negative eigenvalues.
template <std::size_t N>
void make_positive_semidefinite(std::array<double, N * N>& matrix) {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<Matrix> M(matrix.data(), static_cast<Eigen::Index>(N), static_cast<Eigen::Index>(N));
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(M);
  if (solver.info() != Eigen::Success || solver.eigenvalues()[0] >= 0.0) return;
  const auto values = solver.eigenvalues().cwiseMax(0.0).eval();
  M = (solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose()).eval();
}

/// A node of a stencil, and how the variables of the stencil, three by three, depend on it.
template <std::size_t Vectors>
struct StencilNode {
  PetscInt node = 0;
  std::array<double, Vectors> weights{};
};

template <std::size_t Vectors, std::size_t Nodes>
void scatter_gradient(const std::array<StencilNode<Vectors>, Nodes>& nodes,
                      const std::array<double, 3 * Vectors>& gradient, PetscInt num_owned, std::span<double> r) {
  for (const auto& [node, weights] : nodes) {
    if (node >= num_owned) continue;
    for (std::size_t v = 0; v < Vectors; ++v) {
      for (std::size_t i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(node) + i] += weights[v] * gradient[3 * v + i];
    }
  }
}

template <std::size_t Vectors, std::size_t Nodes>
void scatter_hessian(const std::array<StencilNode<Vectors>, Nodes>& nodes,
                     const std::array<double, 9 * Vectors * Vectors>& hessian, PetscInt num_owned,
                     const BlockWriter& K) {
  for (const auto& row : nodes) {
    if (row.node >= num_owned) continue;
    for (const auto& column : nodes) {
      std::array<double, 9> block{};
      for (std::size_t v = 0; v < Vectors; ++v) {
        for (std::size_t w = 0; w < Vectors; ++w) {
          const double factor = row.weights[v] * column.weights[w];
          if (factor == 0.0) continue;
          for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
              block[3 * i + j] += factor * hessian[3 * Vectors * (3 * v + i) + 3 * w + j];
            }
          }
        }
      }
      K.add(row.node, column.node, block);
    }
  }
}

}  // namespace pliant
