/// Neo-Hookean solid with an isochoric-volumetric split.
///   psi = mu/2 (I1b - 3) + kappa U(J)
/// Source: Holzapfel, Nonlinear Solid Mechanics (Wiley, 2000), section 6.5; Simo & Hughes, Computational Inelasticity
/// (Springer, 1998), section 9.2.
#pragma once

#include "material/isochoric.hpp"

namespace pliant {

template <class S>
struct NeoHookeanIsochoric : IsochoricLaw<NeoHookeanIsochoric<S>> {
  static constexpr std::string_view name = "neo-hookean-isochoric";
  static constexpr bool depends_on_i2 = false;

  S mu;  ///< shear modulus [Pa]
  Volumetric<S> volumetric;

  NeoHookeanIsochoric(const S& shear_modulus, const Volumetric<S>& of_volume)
      : mu(shear_modulus), volumetric(of_volume) {}
  static NeoHookeanIsochoric of(const LawData<S>& d) { return {d.parameters[0], {d.parameters[1], d.volumetric}}; }
  LameOf<S> at_rest() const { return {mu, volumetric.kappa - 2.0 / 3.0 * mu}; }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& /*i2*/) const {
    return 0.5 * mu * i1;
  }
  template <class T>
  PLIANT_INLINE DistortionDerivatives<T> derivatives(const T& /*i1*/, const T& /*i2*/) const {
    return {T(0.5 * mu), T(0.0), T(0.0), T(0.0), T(0.0)};
  }
};

static_assert(ElasticLawTemplate<NeoHookeanIsochoric> && IsotropicLaw<NeoHookeanIsochoric<double>>);

}  // namespace pliant
