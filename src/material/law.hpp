/// The contract of an elastic law: pure functions of H = grad u (F = I + H) on a scalar type T, which may be a pack.
///
/// A law is a struct template on S, the type of its parameters (a double, a pack if they differ from cell to cell, or a
/// dual number for the derivatives of an isotropic law by them), with
///   of(data)      the law of these parameters, in the order of its row in the registry
///   psi(H)        strain energy per reference volume [J/m^3]
///   P(H)          first Piola-Kirchhoff stress P_iJ = d psi / d F_iJ [Pa]
///   linearize(H)  an object with the quantities computed once per state: its member `P`, the operator `(dH)` = dP for
///                 the increment dH, and `tangent()`
/// all without cancellation when H is small: at a strain of 1e-8 the rounding error of P is 1e-15 of the stress. psi
/// and P are zero at rest. A law whose energy is a barrier (in J, or at a limit of stretch) declares `is_barrier`: if J
/// <= 0 or the limit is exceeded (or H is NaN), psi is +inf and P, dP and the tangent are NaN, lane by lane, and no
/// floating-point exception is raised. A law with a limit of stretch declares `has_stretch_limit`.
#pragma once

#include "base/dual_math.hpp"
#include "base/simd.hpp"
#include "base/tensor.hpp"
#include "material/lame.hpp"
#include "material/volumetric.hpp"

#include <array>
#include <concepts>
#include <span>
#include <string_view>

namespace pliant {

/// The data from which a law is made.
template <class S>
struct LawData {
  std::span<const S> parameters;                      ///< in the order of the law's row
  VolumetricForm volumetric = VolumetricForm::mixed;  ///< for laws with a volumetric part kappa U(J)
  std::array<std::array<S, 3>, 2> directions{};       ///< for laws with fibres: unit vectors in the reference body
};

/// d P_iJ / d F_kL [Pa] at [9 p + q], p = 3 i + J, q = 3 k + L; symmetric in p and q.
template <class T>
using Tangent = std::array<T, 81>;

/// The tangent with the values f(p, q), p <= q, and the others by symmetry. p and q are compile-time constants.
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

/// The tangent assembled from nine increments dP(dH), for laws without a cheaper formula.
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

/// The concept that a law satisfies for one type of parameters.
template <class L>
concept ElasticLaw = ElasticLawOn<L, Pack> && requires {
  { L::name } -> std::convertible_to<std::string_view>;  // as users type it
  { L::is_barrier } -> std::convertible_to<bool>;        // psi is +inf where J <= 0
  { L::constant_tangent } -> std::convertible_to<bool>;  // dP does not depend on H
  { L::num_directions } -> std::convertible_to<int>;     // 0: isotropic
  { L::energy_degree } -> std::convertible_to<int>;      // of psi, if it is a polynomial of H; otherwise 2
};

template <template <class> class L>
concept ElasticLawTemplate = ElasticLaw<L<double>> && ElasticLawOn < L<double>,
double > &&ElasticLaw<L<Pack>>;

/// An isotropic law reduces to Hooke's law at rest: `at_rest()` returns its Lame parameters.
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
