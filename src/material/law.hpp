/// The contract of an elastic law: pure functions of H = grad u (F = I + H) on a scalar type T, which may be a pack.
///
/// A law is a struct with its parameters and
///   psi(H)        strain energy per reference volume [J/m^3]
///   P(H)          first Piola-Kirchhoff stress P_iJ = d psi / d F_iJ [Pa]
///   linearize(H)  what is worth computing once per state: its member `P`, `(dH)` = dP for the increment dH, and
///   `tangent()`
/// all of them without cancellation when H is small: relative to the stress of a strain of 1e-8 the rounding of P stays
/// at 1e-15. A law whose energy is a barrier in J says so by `needs_positive_volume`: where J <= 0 (or H is NaN) its
/// psi is +inf and its P, dP and tangent are NaN, lane by lane; no floating-point exception is raised there.
#pragma once

#include "base/simd.hpp"
#include "base/tensor.hpp"

#include <array>
#include <concepts>
#include <string_view>

namespace pliant {

/// d P_iJ / d F_kL [Pa] at [9 p + q], p = 3 i + J, q = 3 k + L; symmetric in p and q.
template <class T>
using Tangent = std::array<T, 81>;

/// The tangent of the values f(p, q), p <= q; the rest by symmetry. p and q are compile-time constants.
template <class T, class F>
PLIANT_INLINE Tangent<T> make_symmetric_tangent(const F& f) {
  Tangent<T> A;
  unroll<9>([&](auto p) __attribute__((always_inline)) {
    unroll<9>([&](auto q) __attribute__((always_inline)) {
      if constexpr (p <= q) {
        const T value = f(p, q);
        A[static_cast<std::size_t>(9 * p + q)] = value;
        A[static_cast<std::size_t>(9 * q + p)] = value;
      }
    });
  });
  return A;
}

template <class L, class T>
concept ElasticLawOn = requires(const L& law, const Tensor3<T>& H) {
  { law.psi(H) } -> std::same_as<T>;
  { law.P(H) } -> std::same_as<Tensor3<T>>;
  { law.linearize(H).P } -> std::convertible_to<Tensor3<T>>;
  { law.linearize(H)(H) } -> std::same_as<Tensor3<T>>;
  { law.linearize(H).tangent() } -> std::same_as<Tangent<T>>;
};

template <class L>
concept ElasticLaw = ElasticLawOn<L, double> && ElasticLawOn<L, Pack> && requires(const L& law) {
  { L::name } -> std::convertible_to<std::string_view>;       // as users type it
  { L::needs_positive_volume } -> std::convertible_to<bool>;  // psi is a barrier in J
  { L::constant_tangent } -> std::convertible_to<bool>;       // dP does not depend on H
  { law.mu } -> std::convertible_to<double>;
  { law.lambda } -> std::convertible_to<double>;
};

template <class T, ElasticLaw L>
PLIANT_INLINE Tangent<T> tangent(const L& law, const Tensor3<T>& H) {
  return law.linearize(H).tangent();
}

}  // namespace pliant
