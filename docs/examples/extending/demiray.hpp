/// A law that Pliant does not have: an exponential of the first invariant, for skin, vessels and other soft tissue.
///   psi = mu/(2 b) (exp(b (I1b - 3)) - 1) + kappa U(J)
/// Source: Demiray, J. Biomech. 5 (1972) 309-311.
#pragma once

#include "base/vector_math.hpp"
#include "material/isochoric.hpp"
#include "material/law_info.hpp"

#include <array>
#include <limits>

/// An isochoric law gives W(I1b - 3, I2b - 3) and its derivatives; IsochoricLaw makes stress and tangent of them.
template <class S>
struct Demiray : pliant::IsochoricLaw<Demiray<S>> {
  static constexpr std::string_view name = "demiray";
  static constexpr bool depends_on_i2 = false;

  S mu;  ///< shear modulus at small strain [Pa]
  S b;   ///< stiffening
  pliant::Volumetric<S> volumetric;

  Demiray(const S& shear_modulus, const S& stiffening, const pliant::Volumetric<S>& of_volume)
      : mu(shear_modulus), b(stiffening), volumetric(of_volume) {}
  static Demiray of(const pliant::LawData<S>& d) {
    return {d.parameters[0], d.parameters[1], {d.parameters[2], d.volumetric}};
  }
  pliant::LameOf<S> at_rest() const { return {mu, volumetric.kappa - 2.0 / 3.0 * mu}; }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& /*i2*/) const {
    return mu / (2.0 * b) * pliant::expm1(T(b * i1));
  }
  template <class T>
  PLIANT_INLINE pliant::DistortionDerivatives<T> derivatives(const T& i1, const T& /*i2*/) const {
    const T W1 = 0.5 * mu * pliant::exp(T(b * i1));
    return {W1, T(0.0), T(b * W1), T(0.0), T(0.0)};
  }
};

/// What people read of it, and which keys it has in an input.
inline constexpr double unbounded = std::numeric_limits<double>::infinity();
inline constexpr std::array demiray_parameters{
    pliant::ParameterInfo{"shear_modulus", "Pa", 0.0, unbounded, "stiffness in shear at small strain"},
    pliant::ParameterInfo{"stiffening", "1", 0.0, unbounded, "how fast the stiffness grows with the strain"},
    pliant::ParameterInfo{"bulk_modulus", "Pa", 0.0, unbounded, "stiffness against volume change at small strain"}};
inline constexpr pliant::LawInfo demiray_info{
    Demiray<double>::name, "psi = mu/(2 b) (exp(b (I1b - 3)) - 1) + kappa U(J), b: stiffening", demiray_parameters,
    "Demiray, J. Biomech. 5 (1972)", "soft tissue that stiffens with strain"};
