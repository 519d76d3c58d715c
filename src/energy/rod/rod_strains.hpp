/// The strains of rods as functions of the frames of their segments, with their derivatives.
#pragma once

#include "base/second_order.hpp"
#include "base/vector3.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace pliant {

/// The gradient of a quadratic energy 1/2 sum_k c_k (s_k - s0_k)^2 of M strains s that depend on N numbers.
template <std::size_t N, std::size_t M, int order>
std::array<double, N> gradient_of(const std::array<Differentiated<N, order>, M>& strains,
                                  const std::array<double, M>& rest, const std::array<double, M>& stiffness) {
  std::array<double, N> gradient{};
  for (std::size_t k = 0; k < M; ++k) {
    const double force = stiffness[k] * (strains[k].value - rest[k]);
    for (std::size_t i = 0; i < N; ++i) gradient[i] += force * strains[k].slope[i];
  }
  return gradient;
}

/// Its Hessian, by rows, with the forces c_k (s_k - s0_k) of other strains, `of_forces`, in the place of s.
template <std::size_t N, std::size_t M>
std::array<double, N * N> hessian_of(const std::array<SecondOrder<N>, M>& strains, const std::array<double, M>& rest,
                                     const std::array<double, M>& stiffness, const std::array<double, M>& of_forces) {
  std::array<double, N * N> hessian{};
  for (std::size_t k = 0; k < M; ++k) {
    const SecondOrder<N>& s = strains[k];
    const double force = stiffness[k] * (of_forces[k] - rest[k]);
    for (std::size_t i = 0; i < N; ++i) {
      const double slope = stiffness[k] * s.slope[i];
      for (std::size_t j = 0; j < N; ++j) hessian[N * i + j] += slope * s.slope[j] + force * s.bend_of(i, j);
    }
  }
  return hessian;
}

/// s + ds/dx dx: strains extrapolated along a change dx of what they depend on.
template <std::size_t N, std::size_t M, int order>
std::array<double, M> extrapolated(const std::array<Differentiated<N, order>, M>& strains,
                                   const std::array<double, N>& change) {
  std::array<double, M> result;
  for (std::size_t k = 0; k < M; ++k) {
    result[k] = strains[k].value;
    for (std::size_t i = 0; i < N; ++i) result[k] += strains[k].slope[i] * change[i];
  }
  return result;
}

template <std::size_t N, std::size_t M, int order>
std::array<double, M> values_of(const std::array<Differentiated<N, order>, M>& strains) {
  return extrapolated(strains, {});
}

/// The frame of a segment: t is the derivative of the place by the length along the rod at rest, d the first director.
/// Both are of unit length, and at right angles, where the segment is neither stretched nor distorted.
template <class T>
struct RodFrame {
  Vector3<T> t, d;
};

/// Curvatures kappa_1, kappa_2 and twist between two neighbouring segments a and b. With unit tangents,
///
///     kappa b = 2 t_a x t_b / (1 + t_a . t_b),
///     kappa_1 = kappa b . (m2_a + m2_b) / 2,    kappa_2 = -kappa b . (m1_a + m1_b) / 2,
///
/// where m1 is d without its part along t, of unit length, and m2 = t x m1. The twist is the angle about t_b from m1_a,
/// after its parallel transport from t_a to t_b, to m1_b. Source: Bergou, Audoly, Vouga, Wardetzky & Grinspun 2010,
/// "Discrete viscous threads", section 4, with the material frame in place of an angle from a reference frame: it is a
/// function of the nodes' positions alone.
template <class T>
std::array<T, 3> bending_and_twist(const RodFrame<T>& a, const RodFrame<T>& b) {
  using std::atan2, std::sqrt;
  const auto unit_of = [](const Vector3<T>& x) {
    const T inverse = T(1.0) / sqrt(dot(x, x));
    return Vector3<T>{inverse * x[0], inverse * x[1], inverse * x[2]};
  };
  const auto across = [&](const Vector3<T>& d, const Vector3<T>& t) {
    const T along = dot(d, t);
    return unit_of({d[0] - along * t[0], d[1] - along * t[1], d[2] - along * t[2]});
  };
  const Vector3<T> ta = unit_of(a.t), tb = unit_of(b.t);
  const Vector3<T> m1a = across(a.d, ta), m1b = across(b.d, tb);
  const Vector3<T> m2a = cross(ta, m1a), m2b = cross(tb, m1b);
  const T half = T(1.0) / (T(1.0) + dot(ta, tb));
  const Vector3<T> turn = cross(ta, tb);
  // P m = m - (m . t_b) / (1 + t_a . t_b) (t_a + t_b) for m across t_a.
  const T along = half * dot(m1a, tb);
  const Vector3<T> carried{m1a[0] - along * (ta[0] + tb[0]), m1a[1] - along * (ta[1] + tb[1]),
                           m1a[2] - along * (ta[2] + tb[2])};
  return {half * (dot(turn, m2a) + dot(turn, m2b)), T(-1.0) * (half * (dot(turn, m1a) + dot(turn, m1b))),
          atan2(T(-1.0) * dot(carried, m2b), dot(carried, m1b))};
}

/// Strains within a segment: the stretch |t| - 1 and the distortions t.d1, t.d2, d1.d2, (|d1|^2 - 1)/2, (|d2|^2 - 1)/2
/// of its columns t, d1, d2 = axes + h, which are orthonormal at rest; small ones keep their digits.
inline std::array<double, 6> stretch_and_distortion(const std::array<Vector3<double>, 3>& axes,
                                                    const std::array<Vector3<double>, 3>& h) {
  const auto product = [&](std::size_t i, std::size_t j) {
    return dot(h[i], h[j]) + dot(axes[i], h[j]) + dot(axes[j], h[i]);
  };
  const double square = product(0, 0);  // |t|^2 - 1
  return {square / (1.0 + std::sqrt(1.0 + square)),
          product(0, 1),
          product(0, 2),
          product(1, 2),
          0.5 * product(1, 1),
          0.5 * product(2, 2)};
}

/// The same with their derivatives by the nine components of h.
template <int order>
std::array<Differentiated<9, order>, 6> differentiated_stretch_and_distortion(
    const std::array<Vector3<double>, 3>& axes, const std::array<Vector3<double>, 3>& h) {
  const std::array<double, 6> values = stretch_and_distortion(axes, h);
  const std::array columns{axes[0] + h[0], axes[1] + h[1], axes[2] + h[2]};
  std::array<Differentiated<9, order>, 6> strains;
  for (std::size_t k = 0; k < 6; ++k) strains[k].value = values[k];
  const double length = 1.0 + values[0];
  const Vector3<double> n = (1.0 / length) * columns[0];
  for (std::size_t c = 0; c < 3; ++c) strains[0].slope[c] = n[c];
  if constexpr (order == 2) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j <= i; ++j) strains[0].bend_at(i, j) = ((i == j ? 1.0 : 0.0) - n[i] * n[j]) / length;
    }
  }
  constexpr std::array<std::array<std::size_t, 2>, 5> pairs{{{0, 1}, {0, 2}, {1, 2}, {1, 1}, {2, 2}}};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    const double part = i == j ? 0.5 : 1.0;
    for (std::size_t c = 0; c < 3; ++c) {
      strains[k + 1].slope[3 * i + c] += part * columns[j][c];
      strains[k + 1].slope[3 * j + c] += part * columns[i][c];
      if constexpr (order == 2) strains[k + 1].bend_at(3 * j + c, 3 * i + c) = 1.0;
    }
  }
  return strains;
}

/// What these are more at h than at h0, with the digits of small changes `change` = h - h0.
inline std::array<double, 6> change_of_strains(const std::array<Vector3<double>, 3>& axes,
                                               const std::array<Vector3<double>, 3>& h,
                                               const std::array<Vector3<double>, 3>& h0,
                                               const std::array<Vector3<double>, 3>& change) {
  const auto product = [&](std::size_t i, std::size_t j) {
    return dot(axes[i] + 0.5 * (h[i] + h0[i]), change[j]) + dot(axes[j] + 0.5 * (h[j] + h0[j]), change[i]);
  };
  return {product(0, 0) / (norm(axes[0] + h[0]) + norm(axes[0] + h0[0])),
          product(0, 1),
          product(0, 2),
          product(1, 2),
          0.5 * product(1, 1),
          0.5 * product(2, 2)};
}

}  // namespace pliant
