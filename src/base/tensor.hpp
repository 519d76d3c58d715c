/// Second-order tensors in three dimensions, of any scalar type that adds and multiplies (double, Pack, ...).
#pragma once

#include "base/inline.hpp"

#include <array>
#include <type_traits>
#include <utility>

namespace pliant {

/// f(0), ..., f(n - 1), each index a compile-time constant, so that small arrays live in registers.
template <int n, class F>
PLIANT_INLINE constexpr void unroll(F&& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
    (f(std::integral_constant<int, i>{}), ...);
  }
  (std::make_integer_sequence<int, n>{});
}

/// A 3x3 tensor, row major: A(i, j) = a[3 i + j].
template <class T>
struct Tensor3 {
  std::array<T, 9> a;

  PLIANT_INLINE constexpr T& operator()(int i, int j) { return a[static_cast<std::size_t>(3 * i + j)]; }
  PLIANT_INLINE constexpr const T& operator()(int i, int j) const { return a[static_cast<std::size_t>(3 * i + j)]; }
};

/// The tensor of the values f(i, j).
template <class F>
PLIANT_INLINE constexpr auto make_tensor(const F& f) {
  return Tensor3<std::decay_t<decltype(f(0, 0))>>{
      {f(0, 0), f(0, 1), f(0, 2), f(1, 0), f(1, 1), f(1, 2), f(2, 0), f(2, 1), f(2, 2)}};
}

template <class T>
PLIANT_INLINE constexpr Tensor3<T> identity() {
  const T one = 1.0;
  const T zero = 0.0;
  return {{one, zero, zero, zero, one, zero, zero, zero, one}};
}

template <class T>
PLIANT_INLINE constexpr Tensor3<T> operator+(const Tensor3<T>& A, const Tensor3<T>& B) {
  return make_tensor([&](int i, int j) -> T { return A(i, j) + B(i, j); });
}

template <class T>
PLIANT_INLINE constexpr Tensor3<T> operator-(const Tensor3<T>& A, const Tensor3<T>& B) {
  return make_tensor([&](int i, int j) -> T { return A(i, j) - B(i, j); });
}

/// s A; s is a T or anything that multiplies one.
template <class S, class T>
requires std::convertible_to<S, T> PLIANT_INLINE constexpr Tensor3<T> operator*(const S& s, const Tensor3<T>& A) {
  return make_tensor([&](int i, int j) -> T { return s * A(i, j); });
}

/// A + s I.
template <class T>
PLIANT_INLINE constexpr Tensor3<T> add_to_diagonal(Tensor3<T> A, const std::type_identity_t<T>& s) {
  A(0, 0) += s;
  A(1, 1) += s;
  A(2, 2) += s;
  return A;
}

template <class T>
PLIANT_INLINE constexpr Tensor3<T> transpose(const Tensor3<T>& A) {
  return make_tensor([&](int i, int j) -> T { return A(j, i); });
}

template <class T>
PLIANT_INLINE constexpr T trace(const Tensor3<T>& A) {
  return A(0, 0) + A(1, 1) + A(2, 2);
}

/// A : B = A_ij B_ij.
template <class T>
PLIANT_INLINE constexpr T dot(const Tensor3<T>& A, const Tensor3<T>& B) {
  return (A(0, 0) * B(0, 0) + A(0, 1) * B(0, 1) + A(0, 2) * B(0, 2)) +
         (A(1, 0) * B(1, 0) + A(1, 1) * B(1, 1) + A(1, 2) * B(1, 2)) +
         (A(2, 0) * B(2, 0) + A(2, 1) * B(2, 1) + A(2, 2) * B(2, 2));
}

/// A B.
template <class T>
PLIANT_INLINE constexpr Tensor3<T> matmul(const Tensor3<T>& A, const Tensor3<T>& B) {
  return make_tensor([&](int i, int j) -> T { return A(i, 0) * B(0, j) + A(i, 1) * B(1, j) + A(i, 2) * B(2, j); });
}

/// The second invariant (tr^2 A - tr A^2) / 2, as the sum of the principal minors: less cancels.
template <class T>
PLIANT_INLINE constexpr T second_invariant(const Tensor3<T>& A) {
  return (A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0)) + (A(0, 0) * A(2, 2) - A(0, 2) * A(2, 0)) +
         (A(1, 1) * A(2, 2) - A(1, 2) * A(2, 1));
}

/// cof A = det(A) A^-T.
template <class T>
PLIANT_INLINE constexpr Tensor3<T> cofactor(const Tensor3<T>& A) {
  return make_tensor([&](int i, int j) -> T {
    const int k = (i + 1) % 3, l = (i + 2) % 3;
    const int m = (j + 1) % 3, n = (j + 2) % 3;
    return A(k, m) * A(l, n) - A(k, n) * A(l, m);
  });
}

template <class T>
PLIANT_INLINE constexpr T det(const Tensor3<T>& A) {
  return A(0, 0) * (A(1, 1) * A(2, 2) - A(1, 2) * A(2, 1)) + A(0, 1) * (A(1, 2) * A(2, 0) - A(1, 0) * A(2, 2)) +
         A(0, 2) * (A(1, 0) * A(2, 1) - A(1, 1) * A(2, 0));
}

}  // namespace pliant
