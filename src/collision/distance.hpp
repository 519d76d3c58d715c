/// The distance of two features - points, lines, planes - to second order in the positions of N points.
///
/// One formula serves them all. The vector between the closest points is r = sum w_i x_i, its weights w linear in each
/// of the K parameters s of the features (point-point K = 0, point-line 1, point-plane and line-line 2), and
/// d^2 = min_s |r|^2. With the derivatives w_k = dw/ds_k and the tangents t_k = sum w_k,i x_i, the theorem of implicit
/// functions gives, as r is normal to all t_k,
///
///     d(d^2)/dx_i = 2 w_i r,    d2(d^2)/dx_i dx_j = 2 w_i w_j I - 2 sum_kl b_k,i (T^-1)_kl b_l,j^T,
///     b_k,i = w_k,i r + w_i t_k,    T_kl = t_k . t_l
///
/// in which nothing cancels as d goes to zero. The tangents are made orthonormal first (and w_k with them), so that T =
/// I. The points may be more than the corners of the features: a point that is a combination of nodes takes part by its
/// weights.
#pragma once

#include "collision/closest_points.hpp"
#include "collision/expansion.hpp"

#include <array>
#include <cmath>

namespace pliant {

/// The features that are closest, as weights of N points.
template <int N>
struct Stencil {
  std::array<double, N> weights{};                ///< w: r = sum w_i x_i from the second feature to the first
  std::array<std::array<double, N>, 2> slopes{};  ///< w_k; those from num_slopes on are zero
  int num_slopes = 0;                             ///< K
};

/// Points in the order of the functions closest_...
Stencil<3> stencil_of(const PointEdge& closest);
Stencil<4> stencil_of(const PointTriangle& closest);
Stencil<4> stencil_of(const EdgeEdge& closest);
/// The stencil of two points.
Stencil<2> point_point_stencil();

/// A point that is the combination `point` of A nodes and a triangle, in A + 3 points: the nodes, then the corners.
template <int A>
Stencil<A + 3> stencil_of(const std::array<double, A>& point, const PointTriangle& closest) {
  const Stencil<4> simple = stencil_of(closest);
  Stencil<A + 3> stencil;
  stencil.num_slopes = simple.num_slopes;
  for (int a = 0; a < A; ++a) stencil.weights[a] = point[a];
  for (int corner = 0; corner < 3; ++corner) {
    stencil.weights[A + corner] = simple.weights[1 + corner];
    for (int k = 0; k < simple.num_slopes; ++k) stencil.slopes[k][A + corner] = simple.slopes[k][1 + corner];
  }
  return stencil;
}

/// A stencil at given positions. Where d = 0 the normal may be NaN, and squared_distance still holds.
template <int N>
struct Separation {
  double distance = 0.0;     ///< d [m]
  Vector3<double> r{};       ///< from the second feature to the first [m]
  Vector3<double> normal{};  ///< n = r / d
  std::array<double, N> weights{};
  std::array<Vector3<double>, 2> tangents{};      ///< t_k, orthonormal; zero from num_slopes on
  std::array<std::array<double, N>, 2> slopes{};  ///< w_k that belong to these tangents [1/m]
  int num_slopes = 0;
};

/// sum w_i x_i of weights that add up to zero: from differences, which keep their digits far from the origin.
template <int N>
Vector3<double> combine(const std::array<double, N>& weights, std::span<const Vector3<double>, N> x) {
  Vector3<double> total{};
  for (int i = 1; i < N; ++i) total = total + weights[i] * (x[i] - x[0]);
  return total;
}

template <int N>
Separation<N> separation(const Stencil<N>& stencil, std::span<const Vector3<double>, N> x) {
  Separation<N> at{.weights = stencil.weights, .slopes = stencil.slopes, .num_slopes = stencil.num_slopes};
  at.r = combine<N>(stencil.weights, x);
  for (int k = 0; k < at.num_slopes; ++k) {  // Gram and Schmidt
    Vector3<double> t = combine<N>(at.slopes[k], x);
    if (k == 1) {
      const double along = dot(t, at.tangents[0]);
      t = t - along * at.tangents[0];
      for (int i = 0; i < N; ++i) at.slopes[1][i] -= along * at.slopes[0][i];
    }
    const double scale = 1.0 / norm(t);
    at.tangents[k] = scale * t;
    for (double& slope : at.slopes[k]) slope *= scale;
    at.r = at.r - dot(at.r, at.tangents[k]) * at.tangents[k];
  }
  at.distance = norm(at.r);
  at.normal = (1.0 / at.distance) * at.r;
  if (at.num_slopes == 2) {  // keeps its digits where d is a rounding of the coordinates
    const Vector3<double> across = cross(at.tangents[0], at.tangents[1]);
    at.normal = std::copysign(1.0 / norm(across), dot(across, at.r)) * across;
  }
  return at;
}

/// d^2 [m^2] and its derivatives.
template <int N>
Expansion<N> squared_distance(const Separation<N>& at) {
  Expansion<N> f;
  f.value = dot(at.r, at.r);
  std::array<std::array<Vector3<double>, N>, 2> b{};
  for (int i = 0; i < N; ++i) {
    f.gradient[i] = (2.0 * at.weights[i]) * at.r;
    for (int k = 0; k < at.num_slopes; ++k) b[k][i] = at.slopes[k][i] * at.r + at.weights[i] * at.tangents[k];
  }
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      const double ww = at.weights[i] * at.weights[j];
      f.block(i, j) = make_tensor([&](int p, int q) {
        return 2.0 * ((p == q ? ww : 0.0) - b[0][i][p] * b[0][j][q] - b[1][i][p] * b[1][j][q]);
      });
    }
  }
  return f;
}

}  // namespace pliant
