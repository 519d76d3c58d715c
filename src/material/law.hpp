/// The contract of an elastic law: pure functions of H = grad u (F = I + H) on a scalar type T, which may be a pack.
///
/// A law is a struct template on S, the type of its parameters (a double, or a pack where they differ from cell to
/// cell), with
///   of(data)      the law of these parameters, in the order of its row in the registry
///   psi(H)        strain energy per reference volume [J/m^3]
///   P(H)          first Piola-Kirchhoff stress P_iJ = d psi / d F_iJ [Pa]
///   linearize(H)  what is worth computing once per state: its member `P`, `(dH)` = dP for the increment dH, and
///   `tangent()`
/// all of them without cancellation when H is small: relative to the stress of a strain of 1e-8 the rounding of P stays
/// at 1e-15. psi and P are zero at rest. A law whose energy is a barrier (in J, or at a limit of stretch) says so by
/// `is_barrier`: where J <= 0 or the limit is passed (or H is NaN) its psi is +inf and its P, dP and tangent are NaN,
/// lane by lane; no floating-point exception is raised there. A law with a limit of stretch says so by
/// `has_stretch_limit`.
#pragma once

#include "base/simd.hpp"
#include "base/tensor.hpp"
#include "material/lame.hpp"
#include "material/volumetric.hpp"

#include <array>
#include <concepts>
#include <span>
#include <string_view>

namespace pliant {

/// What a law is made of.
template <class S>
struct LawData {
  std::span<const S> parameters;                      ///< in the order of the law's row
  VolumetricForm volumetric = VolumetricForm::mixed;  ///< of laws with a volumetric part of their own
  std::array<std::array<S, 3>, 2> directions{};       ///< of laws with fibres: unit vectors in the reference body
};

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

/// The tangent of the increments dP(dH), from nine of them, for laws without a cheaper way.
template <class T, class F>
PLIANT_INLINE Tangent<T> tangent_by_columns(const F& dP) {
  Tangent<T> A;
  for (std::size_t q = 0; q < 9; ++q) {
    Tensor3<T> dH{};
    dH.a[q] = T(1.0);
    const Tensor3<T> column = dP(dH);
    for (std::size_t p = 0; p <= q; ++p) A[9 * p + q] = A[9 * q + p] = column.a[p];
  }
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

/// Of one type of parameters: what a template is checked with.
template <class L>
concept ElasticLaw = ElasticLawOn<L, Pack> && requires {
  { L::name } -> std::convertible_to<std::string_view>;  // as users type it
  { L::is_barrier } -> std::convertible_to<bool>;        // psi is +inf where J <= 0
  { L::constant_tangent } -> std::convertible_to<bool>;  // dP does not depend on H
  { L::num_directions } -> std::convertible_to<int>;     // 0: isotropic
  { L::energy_degree } -> std::convertible_to<int>;      // of psi, where it is a polynomial of H; else 2
};

template <template <class> class L>
concept ElasticLawTemplate = ElasticLaw<L<double>> && ElasticLawOn < L<double>,
double > &&ElasticLaw<L<Pack>>;

/// An isotropic law has Hooke's law at rest: `at_rest()` is its Lame parameters.
template <class L>
concept IsotropicLaw = L::num_directions == 0 && requires(const L& law) {
  law.at_rest().mu;
  law.at_rest().lambda;
};

template <class T, ElasticLaw L>
PLIANT_INLINE Tangent<T> tangent(const L& law, const Tensor3<T>& H) {
  return law.linearize(H).tangent();
}

}  // namespace pliant
