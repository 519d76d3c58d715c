/// Volumetric energies kappa U(J), with j = J - 1, in forms that remain accurate when j is small.
///
///   log        U = 1/2 (ln J)^2
///   quadratic  U = 1/2 (J - 1)^2
///   mixed      U = 1/4 (J^2 - 1 - 2 ln J)
///
/// All have U = j^2/2 + O(j^3). `log` softens in extension beyond J = e and is not convex there, `quadratic` stays
/// finite at J = 0, `mixed` is convex and a barrier.
/// Sources: Simo & Taylor, Comput. Methods Appl. Mech. Eng. 85 (1991) 273-310 (mixed); Hartmann & Neff, Int. J. Solids
/// Struct. 40 (2003) 2767-2791 (comparison).
#pragma once

#include "base/simd.hpp"
#include "material/volumetric_form.hpp"

#include <cmath>

namespace pliant {

/// g(j) with U = g^2 / 2 and the sign of j, and its derivatives: the function that an independent pressure multiplies.
template <class T>
struct VolumeMeasure {
  T g, slope, curvature;
};

/// The function g of a form, for j > -1.
///   log  g = ln J      quadratic  g = J - 1      mixed  g = j r, r = sqrt(1/2 + (j - ln J)/j^2),
/// the last with g' = (2 + j)/(2 J r) from g g' = U', and g'' = g' (1/(2 + j) - 1/J - r'/r), where
/// (r^2)' = (1/J - 2 (j - ln J)/j^2)/j = -1/3 + 2/4 j - 3/5 j^2 + ... needs its series when j is small.
template <class T>
PLIANT_INLINE VolumeMeasure<T> volume_measure(VolumetricForm form, const T& j) {
  const T J = 1.0 + j;
  if (form == VolumetricForm::quadratic) return {j, T(1.0), T(0.0)};
  if (form == VolumetricForm::log) return {log1p(j), 1.0 / J, -1.0 / (J * J)};
  const T j2 = j * j;
  const auto tiny = j2 < 1e-200;
  const T ratio = select(tiny, T(0.5), T(x_minus_log1p(j) / select(tiny, T(1.0), j2)));
  using std::sqrt;
  const T r = sqrt(T(0.5 + ratio));
  const auto small = j2 < 1e-4;
  const T series =
      -1.0 / 3 + j * (2.0 / 4 + j * (-3.0 / 5 + j * (4.0 / 6 + j * (-5.0 / 7 + j * (6.0 / 8 - 7.0 / 9 * j)))));
  const T closed = (1.0 / J - 2.0 * ratio) / select(small, T(1.0), j);
  const T slope = (2.0 + j) / (2.0 * J * r);
  const T fall = select(small, series, closed) / (2.0 * (r * r));  // r'/r
  return {j * r, slope, slope * (1.0 / (2.0 + j) - 1.0 / J - fall)};
}

template <class T>
struct VolumetricStress {
  T value;  ///< kappa J U' [Pa]: the Kirchhoff pressure
  T slope;  ///< J d/dJ of it [Pa]
};

template <class S>
struct Volumetric {
  S kappa;  ///< bulk modulus [Pa]
  VolumetricForm form;

  /// kappa U [J/m^3]; j > -1.
  template <class T>
  PLIANT_INLINE T energy(const T& j) const {
    if (form == VolumetricForm::quadratic) return 0.5 * kappa * (j * j);
    if (form == VolumetricForm::mixed) return 0.25 * kappa * (j * j + 2.0 * x_minus_log1p(j));
    const T l = log1p(j);
    return 0.5 * kappa * (l * l);
  }

  template <class T>
  PLIANT_INLINE VolumetricStress<T> stress(const T& j) const {
    const T J = 1.0 + j;
    if (form == VolumetricForm::quadratic) return {kappa * (j * J), kappa * (J * (J + j))};
    if (form == VolumetricForm::mixed) return {0.5 * kappa * (j * (2.0 + j)), kappa * (J * J)};
    return {kappa * log1p(j), T(kappa)};
  }
};

}  // namespace pliant
