/// Laws of viscosity in the Green-Lagrange strain E and its rate: invariant under rotation, linear in E.
///
///   Kelvin-Voigt   R = shear dev(Edot):dev(Edot) + bulk/2 tr(Edot)^2     dissipation potential [W/m^3]
///                  S = 2 shear dev(Edot) + bulk tr(Edot) I               stress added to the elastic one [Pa]
///   stiffness-proportional: Kelvin-Voigt with time C0, C0 the elastic tangent at rest
///   Maxwell        Gdot = (E - G)/tau,  G the strain of the dashpot of a spring and a dashpot in series
///                  psi = mu_b dev(E - G):dev(E - G) + kappa_b/2 tr(E - G)^2   stored in the spring [J/m^3]
///                  S = 2 mu_b dev(E - G) + kappa_b tr(E - G) I                [Pa]
///                  (E - G):S/tau                                              dissipated [W/m^3]
///
///   Prony          Hdot + H/tau = g d/dt S_e, S_e the stress of the elastic law
///
/// all per reference volume; the first Piola-Kirchhoff stress is P = F S. The potentials of Kelvin-Voigt and Maxwell
/// are quadratic forms of an isotropic tensor, and so are their incremental potentials over a time dt
/// (energy/volume/viscous.hpp). Mass-proportional damping, R = alpha/2 rho v.v, acts on the velocity itself.
/// Sources: Landau & Lifshitz, Theory of Elasticity (3rd ed. 1986), section 34 (Kelvin-Voigt); Holzapfel, Nonlinear
/// Solid Mechanics (Wiley, 2000), section 6.10, and Kumar & Lopez-Pamies, C. R. Mecanique 344 (2016), 102-112
/// (Maxwell).
#pragma once

#include "base/tensor.hpp"

#include <string_view>

namespace pliant {

/// How a stage that starts at q0 and lasts dt forms Edot from the configuration q at its end: chosen for a term, not
/// part of its law.
enum class StrainRate {
  secant,         ///< (E(q) - E(q0)) / dt; has a potential; first order in time for every method
  reconstructed,  ///< (E(q) - E0) / dt, E0 from earlier stages' strains as q0 from their q; has a potential
  exact           ///< sym(F^T (F - F0)) / dt; keeps the order of every method; has no potential
};

/// The isotropic tensor C of fourth order on symmetric D: C:D = 2 shear dev(D) + bulk tr(D) I.
template <class S>
struct IsotropicTensor {
  S shear;  ///< [Pa] on strains, [Pa s] on rates
  S bulk;

  /// The factor of tr(D) I, next to 2 shear D: bulk - 2/3 shear.
  PLIANT_INLINE constexpr S lambda() const { return bulk - 2.0 / 3.0 * shear; }

  PLIANT_INLINE Tensor3<S> operator()(const Tensor3<S>& D) const {
    return add_to_diagonal(2.0 * shear * D, lambda() * trace(D));
  }
};

template <class S>
PLIANT_INLINE constexpr IsotropicTensor<S> operator*(const std::type_identity_t<S>& s, const IsotropicTensor<S>& C) {
  return {s * C.shear, s * C.bulk};
}

/// How the moduli of a law are given.
enum class Moduli {
  absolute,  ///< SI
  relative   ///< relative to the elastic law's moduli at rest
};

struct KelvinVoigt {
  static constexpr std::string_view name = "kelvin-voigt";

  double shear;  ///< [Pa s]
  double bulk;   ///< [Pa s]
};

struct Maxwell {
  static constexpr std::string_view name = "maxwell";

  double shear_modulus;    ///< mu_b [Pa], or mu_b / mu
  double bulk_modulus;     ///< kappa_b [Pa], or kappa_b / K
  double relaxation_time;  ///< tau [s]
  Moduli moduli = Moduli::absolute;
};

struct StiffnessProportional {
  static constexpr std::string_view name = "stiffness-proportional";

  double time;                     ///< beta [s]
  bool resists_dilatation = true;  ///< false: the shear part of C0 alone
};

/// A branch whose stress follows the elastic law and relaxes.
struct Prony {
  static constexpr std::string_view name = "prony";

  double ratio;            ///< g: stress of the branch in fast motion relative to the elastic stress
  double relaxation_time;  ///< tau [s]
};

struct MassProportional {
  static constexpr std::string_view name = "mass-proportional";

  double decay_rate;  ///< alpha [1/s]
};

}  // namespace pliant
