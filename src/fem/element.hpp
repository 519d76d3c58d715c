/// Lagrange shape functions on the reference tetrahedron {xi >= 0, xi1 + xi2 + xi3 <= 1}, triangle and line.
/// Corners first, then mid-edge nodes in VTK's order of edges: 01 12 02 03 13 23 (triangle: 01 12 02, line: 01).
#pragma once

#include <array>

namespace pliant {

/// Corners of the six edges of a tetrahedron, in the order of the mid-edge nodes.
inline constexpr std::array<std::array<int, 2>, 6> tet_edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
inline constexpr std::array<std::array<int, 2>, 3> triangle_edges{{{0, 1}, {1, 2}, {0, 2}}};

/// Shape functions of polynomial degree Order (1 or 2) on a simplex of dimension Dim (1, 2 or 3).
template <int Dim, int Order>
struct Simplex {
  static constexpr int dim = Dim;
  static constexpr int order = Order;
  static constexpr int num_corners = Dim + 1;
  static constexpr int num_edges = Dim * (Dim + 1) / 2;
  static constexpr int num_nodes = num_corners + (Order == 2 ? num_edges : 0);
  using Point = std::array<double, Dim>;

  static constexpr std::array<int, 2> edge(int e) {
    if constexpr (Dim == 3) {
      return tet_edges[e];
    } else {
      return triangle_edges[e];
    }
  }

  /// N_a(xi)
  static constexpr std::array<double, num_nodes> values(const Point& xi) {
    const auto l = barycentric(xi);
    std::array<double, num_nodes> n{};
    for (int a = 0; a < num_corners; ++a) n[a] = Order == 1 ? l[a] : l[a] * (2.0 * l[a] - 1.0);
    if constexpr (Order == 2) {
      for (int e = 0; e < num_edges; ++e) n[num_corners + e] = 4.0 * l[edge(e)[0]] * l[edge(e)[1]];
    }
    return n;
  }

  /// Whether N_a depends on the barycentric coordinate l_k.
  static constexpr bool depends(int a, int k) {
    return a < num_corners ? a == k : edge(a - num_corners)[0] == k || edge(a - num_corners)[1] == k;
  }

  /// dN_a/dl_k
  static constexpr std::array<std::array<double, num_corners>, num_nodes> barycentric_gradients(const Point& xi) {
    const auto l = barycentric(xi);
    std::array<std::array<double, num_corners>, num_nodes> g{};
    for (int a = 0; a < num_corners; ++a) g[a][a] = Order == 1 ? 1.0 : 4.0 * l[a] - 1.0;
    if constexpr (Order == 2) {
      for (int e = 0; e < num_edges; ++e) {
        const auto [i, j] = edge(e);
        g[num_corners + e][i] = 4.0 * l[j];
        g[num_corners + e][j] = 4.0 * l[i];
      }
    }
    return g;
  }

  /// dN_a/dxi_k
  static constexpr std::array<std::array<double, Dim>, num_nodes> gradients(const Point& xi) {
    const auto by_l = barycentric_gradients(xi);
    std::array<std::array<double, Dim>, num_nodes> g{};
    for (int a = 0; a < num_nodes; ++a) {
      for (int k = 0; k < Dim; ++k) g[a][k] = by_l[a][k + 1] - by_l[a][0];  // l_0 = 1 - xi_1 - ... - xi_Dim
    }
    return g;
  }

 private:
  static constexpr std::array<double, num_corners> barycentric(const Point& xi) {
    std::array<double, num_corners> l{};
    l[0] = 1.0;
    for (int k = 0; k < Dim; ++k) {
      l[k + 1] = xi[k];
      l[0] -= xi[k];
    }
    return l;
  }
};

template <int Order>
using Tet = Simplex<3, Order>;
template <int Order>
using Triangle = Simplex<2, Order>;
template <int Order>
using Line = Simplex<1, Order>;

}  // namespace pliant
