/// Energies of a change of volume, kappa U(J), with j = J - 1, in forms that keep their digits when j is small.
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

#include <array>
#include <string_view>

namespace pliant {

enum class VolumetricForm { log, quadratic, mixed };

/// As users type them, in the order of VolumetricForm.
inline constexpr std::array<std::string_view, 3> volumetric_form_names{"log", "quadratic", "mixed"};

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
  struct Stress {
    T value;  ///< kappa J U' [Pa]: the Kirchhoff pressure
    T slope;  ///< J d/dJ of it [Pa]
  };
  template <class T>
  PLIANT_INLINE Stress<T> stress(const T& j) const {
    const T J = 1.0 + j;
    if (form == VolumetricForm::quadratic) return {kappa * (j * J), kappa * (J * (J + j))};
    if (form == VolumetricForm::mixed) return {0.5 * kappa * (j * (2.0 + j)), kappa * (J * J)};
    return {kappa * log1p(j), T(kappa)};
  }
};

}  // namespace pliant
