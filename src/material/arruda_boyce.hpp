/// Arruda and Boyce's eight-chain model of a network of polymer chains of limited length: the first five terms of the
/// series of its energy,
///   psi = C_R sum_k a_k / lm^(2k-2) (I1b^k - 3^k) + kappa U(J),   a = 1/2, 1/20, 11/1050, 19/7000, 519/673750
/// lm is the stretch at which the chains lock. Source: Arruda & Boyce, J. Mech. Phys. Solids 41 (1993) 389-412.
///
/// The paper's C_R = n k theta is not the shear modulus at rest, which is
///   mu = C_R (1 + 3/(5 lm^2) + 99/(175 lm^4) + 513/(875 lm^6) + 42039/(67375 lm^8));
/// the parameter of the law is mu, and C_R follows. Computed as a polynomial of I1b - 3, so that nothing cancels.
#pragma once

#include "material/isochoric.hpp"

namespace pliant {

template <class S>
struct ArrudaBoyce : IsochoricLaw<ArrudaBoyce<S>> {
  static constexpr std::string_view name = "arruda-boyce";
  static constexpr bool depends_on_i2 = false;

  S mu;               ///< shear modulus at rest [Pa]
  S locking_stretch;  ///< lm
  Volumetric<S> volumetric;
  S network_modulus;   ///< C_R [Pa]
  std::array<S, 5> c;  ///< of (I1b - 3)^1 to (I1b - 3)^5 [Pa]

  static constexpr std::array<double, 5> series{1.0 / 2, 1.0 / 20, 11.0 / 1050, 19.0 / 7000, 519.0 / 673750};

  ArrudaBoyce(const S& shear_modulus, const S& stretch, const Volumetric<S>& of_volume)
      : mu(shear_modulus), locking_stretch(stretch), volumetric(of_volume), network_modulus(), c() {
    // c_m = C_R sum_k a_k lm^(2-2k) binomial(k, m) 3^(k-m)
    S power = 1.0;  // lm^(2-2k)
    for (int k = 1; k <= 5; ++k) {
      double term = series[static_cast<std::size_t>(k - 1)];
      for (int m = k; m >= 1; --m) {
        c[static_cast<std::size_t>(m - 1)] += term * power;
        term *= 3.0 * m / (k - m + 1);
      }
      power = power / (stretch * stretch);
    }
    network_modulus = 0.5 * mu / c[0];
    for (S& coefficient : c) coefficient = network_modulus * coefficient;
  }
  static ArrudaBoyce of(const LawData<S>& d) {
    return {d.parameters[0], d.parameters[2], {d.parameters[1], d.volumetric}};
  }
  LameOf<S> at_rest() const { return {mu, volumetric.kappa - 2.0 / 3.0 * mu}; }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& /*i2*/) const {
    return i1 * (c[0] + i1 * (c[1] + i1 * (c[2] + i1 * (c[3] + i1 * c[4]))));
  }
  template <class T>
  PLIANT_INLINE DistortionDerivatives<T> derivatives(const T& i1, const T& /*i2*/) const {
    const T w1 = c[0] + i1 * (2.0 * c[1] + i1 * (3.0 * c[2] + i1 * (4.0 * c[3] + i1 * (5.0 * c[4]))));
    const T w11 = 2.0 * c[1] + i1 * (6.0 * c[2] + i1 * (12.0 * c[3] + i1 * (20.0 * c[4])));
    return {w1, T(0.0), w11, T(0.0), T(0.0)};
  }
};

static_assert(ElasticLawTemplate<ArrudaBoyce> && IsotropicLaw<ArrudaBoyce<double>>);

}  // namespace pliant
