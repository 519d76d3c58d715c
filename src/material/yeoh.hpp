/// Yeoh's solid: a cubic polynomial of the first invariant, for rubbers whose stiffness first decreases, then
/// increases.
///   psi = c10 (I1b - 3) + c20 (I1b - 3)^2 + c30 (I1b - 3)^3 + kappa U(J)
/// Source: Yeoh, Rubber Chem. Technol. 66 (1993) 754-771.
#pragma once

#include "material/isochoric.hpp"

namespace pliant {

template <class S>
struct Yeoh : IsochoricLaw<Yeoh<S>> {
  static constexpr std::string_view name = "yeoh";
  static constexpr bool depends_on_i2 = false;

  S c10, c20, c30;  ///< [Pa]
  Volumetric<S> volumetric;

  Yeoh(const std::array<S, 3>& c, const Volumetric<S>& of_volume)
      : c10(c[0]), c20(c[1]), c30(c[2]), volumetric(of_volume) {}
  static Yeoh of(const LawData<S>& d) {
    return {{d.parameters[0], d.parameters[1], d.parameters[2]}, {d.parameters[3], d.volumetric}};
  }
  LameOf<S> at_rest() const {
    const S mu = 2.0 * c10;
    return {mu, volumetric.kappa - 2.0 / 3.0 * mu};
  }

  template <class T>
  PLIANT_INLINE T W(const T& i1, const T& /*i2*/) const {
    return i1 * (c10 + i1 * (c20 + c30 * i1));
  }
  template <class T>
  PLIANT_INLINE DistortionDerivatives<T> derivatives(const T& i1, const T& /*i2*/) const {
    return {c10 + i1 * (2.0 * c20 + 3.0 * c30 * i1), T(0.0), 2.0 * c20 + 6.0 * c30 * i1, T(0.0), T(0.0)};
  }
};

static_assert(ElasticLawTemplate<Yeoh> && IsotropicLaw<Yeoh<double>>);

}  // namespace pliant
