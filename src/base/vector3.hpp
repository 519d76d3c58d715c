/// Vectors in three dimensions, of any scalar type that adds and multiplies (double, Dual, ...).
#pragma once

#include "base/tensor.hpp"

#include <array>
#include <cmath>

namespace pliant {

template <class T>
using Vector3 = std::array<T, 3>;

template <class T>
constexpr Vector3<T> operator+(const Vector3<T>& a, const Vector3<T>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

template <class T>
constexpr Vector3<T> operator-(const Vector3<T>& a, const Vector3<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// s a; s is a T or anything that multiplies one.
template <class S, class T>
requires std::convertible_to<S, T>
constexpr Vector3<T> operator*(const S& s, const Vector3<T>& a) {
  return {s * a[0], s * a[1], s * a[2]};
}

template <class T>
PLIANT_INLINE constexpr T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
PLIANT_INLINE constexpr Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double norm(const Vector3<double>& a) {
  return std::sqrt(dot(a, a));
}

/// a / |a|
inline Vector3<double> unit(const Vector3<double>& a) {
  return (1.0 / norm(a)) * a;
}

/// a (x) b.
template <class T>
PLIANT_INLINE constexpr Tensor3<T> outer(const Vector3<T>& a, const Vector3<T>& b) {
  return make_tensor([&](int i, int j) -> T { return a[i] * b[j]; });
}

/// A a; A is of a's scalars or of constants.
template <class S, class T>
PLIANT_INLINE constexpr Vector3<T> matvec(const Tensor3<S>& A, const Vector3<T>& a) {
  return {A(0, 0) * a[0] + A(0, 1) * a[1] + A(0, 2) * a[2], A(1, 0) * a[0] + A(1, 1) * a[1] + A(1, 2) * a[2],
          A(2, 0) * a[0] + A(2, 1) * a[1] + A(2, 2) * a[2]};
}

}  // namespace pliant
