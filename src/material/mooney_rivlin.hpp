/// Mooney-Rivlin solids with two and with five terms.
///   psi  = c10 (I1b - 3) + c01 (I2b - 3) + kappa U(J)
///   psi5 = psi + c20 (I1b - 3)^2 + c11 (I1b - 3)(I2b - 3) + c02 (I2b - 3)^2
/// Sources: Mooney, J. Appl. Phys. 11 (1940) 582-592; Rivlin, Phil. Trans. R. Soc. A 241 (1948) 379-397; Holzapfel,
/// Nonlinear Solid Mechanics (Wiley, 2000), section 6.5.
#pragma once

#include "material/isochoric.hpp"

namespace pliant {

template <class S>
struct MooneyRivlin : IsochoricLaw<MooneyRivlin<S>> {
  static constexpr std::string_view name = "mooney-rivlin";
  static constexpr bool depends_on_i2 = true;

  S c10, c01;  ///< [Pa]
  Volumetric<S> volumetric;

  MooneyRivlin(const S& first, const S& second, const Volumetric<S>& of_volume)
      : c10(first), c01(second), volumetric(of_volume) {}
  static MooneyRivlin of(const LawData<S>& d) {
    return {d.parameters[0], d.parameters[1], {d.parameters[2], d.volumetric}};
  }
  LameOf<S> at_rest() const {
    const S mu = 2.0 * (c10 + c01);
    return {mu, volumetric.kappa - 2.0 / 3.0 * mu};
  }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& i2) const {
    return c10 * i1 + c01 * i2;
  }
  template <class T>
  PLIANT_INLINE DistortionDerivatives<T> derivatives(const T& /*i1*/, const T& /*i2*/) const {
    return {T(c10), T(c01), T(0.0), T(0.0), T(0.0)};
  }
};

template <class S>
struct MooneyRivlin5 : IsochoricLaw<MooneyRivlin5<S>> {
  static constexpr std::string_view name = "mooney-rivlin-5";
  static constexpr bool depends_on_i2 = true;

  S c10, c01, c20, c11, c02;  ///< [Pa]
  Volumetric<S> volumetric;

  explicit MooneyRivlin5(const LawData<S>& d)
      : c10(d.parameters[0]),
        c01(d.parameters[1]),
        c20(d.parameters[2]),
        c11(d.parameters[3]),
        c02(d.parameters[4]),
        volumetric{d.parameters[5], d.volumetric} {}
  static MooneyRivlin5 of(const LawData<S>& d) { return MooneyRivlin5(d); }
  LameOf<S> at_rest() const {
    const S mu = 2.0 * (c10 + c01);
    return {mu, volumetric.kappa - 2.0 / 3.0 * mu};
  }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& i2) const {
    return i1 * (c10 + c20 * i1 + c11 * i2) + i2 * (c01 + c02 * i2);
  }
  template <class T>
  PLIANT_INLINE DistortionDerivatives<T> derivatives(const T& i1, const T& i2) const {
    return {c10 + 2.0 * c20 * i1 + c11 * i2, c01 + c11 * i1 + 2.0 * c02 * i2, T(2.0 * c20), T(c11), T(2.0 * c02)};
  }
};

static_assert(ElasticLawTemplate<MooneyRivlin> && IsotropicLaw<MooneyRivlin<double>>);
static_assert(ElasticLawTemplate<MooneyRivlin5> && IsotropicLaw<MooneyRivlin5<double>>);

}  // namespace pliant
