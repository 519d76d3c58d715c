/// Gent's solid: neo-Hookean at small strain, and increasingly stiff towards a limit of stretch that it never reaches.
///   psi = -mu Jm/2 ln(1 - (I1b - 3)/Jm) + kappa U(J)
/// Source: Gent, Rubber Chem. Technol. 69 (1996) 59-61.
/// Its energy also has a barrier at I1b - 3 = Jm, beyond which psi is +inf and its derivatives are NaN.
#pragma once

#include "material/isochoric.hpp"

namespace pliant {

template <class S>
struct Gent : IsochoricLaw<Gent<S>> {
  static constexpr std::string_view name = "gent";
  static constexpr bool depends_on_i2 = false;
  static constexpr bool has_stretch_limit = true;

  S mu;             ///< shear modulus [Pa]
  S stretch_limit;  ///< Jm: the least upper bound of I1b - 3
  Volumetric<S> volumetric;

  Gent(const S& shear_modulus, const S& limit, const Volumetric<S>& of_volume)
      : mu(shear_modulus), stretch_limit(limit), volumetric(of_volume) {}
  static Gent of(const LawData<S>& d) { return {d.parameters[0], d.parameters[2], {d.parameters[1], d.volumetric}}; }
  LameOf<S> at_rest() const { return {mu, volumetric.kappa - 2.0 / 3.0 * mu}; }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& /*i2*/) const {
    const T room = stretch_limit - i1;
    const T used = select(room > 0.0, i1, T(0.0)) / stretch_limit;
    const T value = -0.5 * mu * stretch_limit * log1p(T(-used));
    return select(room > 0.0, value, T(std::numeric_limits<double>::infinity()));
  }
  template <class T>
  PLIANT_INLINE DistortionDerivatives<T> derivatives(const T& i1, const T& /*i2*/) const {
    const T room = select(stretch_limit - i1 > 0.0, T(stretch_limit - i1), T(std::numeric_limits<double>::quiet_NaN()));
    const T w1 = 0.5 * mu * stretch_limit / room;
    return {w1, T(0.0), w1 / room, T(0.0), T(0.0)};
  }
};

static_assert(ElasticLawTemplate<Gent> && IsotropicLaw<Gent<double>>);

}  // namespace pliant
