/// Two families of dispersed fibres in a neo-Hookean ground matrix: walls of arteries.
///   psi = mu/2 (I1b - 3) + k1/(2 k2) sum_i (exp(k2 <Ei>^2) - 1) + kappa U(J)
///   Ei = d (I1b - 3) + (1 - 3 d) (I4b_i - 1),  <x> = max(x, 0): fibres do not push
/// with the dispersion d: 0 if all fibres of a family are parallel, 1/3 if all directions are equal. Unlike in the
/// paper, Ei itself is cut off at 0, not I4 alone, which makes the stresses continuous. Source: Gasser, Ogden &
/// Holzapfel, J. R. Soc. Interface 3 (2006) 15-35, equations 4.1 to 4.4.
#pragma once

#include "material/fibre.hpp"

namespace pliant {

template <class S>
struct HolzapfelGasserOgden : FibreLaw<HolzapfelGasserOgden<S>> {
  static constexpr std::string_view name = "holzapfel-gasser-ogden";
  static constexpr int num_directions = 2;

  S mu;                      ///< shear modulus of the ground [Pa]
  ExponentialFibre<S> pull;  ///< k1 [Pa], k2
  S dispersion;
  Volumetric<S> volumetric;
  std::array<std::array<S, 3>, 2> families;

  static HolzapfelGasserOgden of(const LawData<S>& d) {
    const auto& p = d.parameters;
    return {{}, p[0], {p[2], p[3]}, p[4], {p[1], d.volumetric}, d.directions};
  }

  template <class T>
  struct Linearization : FibreLinearization<Linearization<T>, T> {
    using Base = FibreLinearization<Linearization, T>;
    using Base::s, Base::pressure, Base::slope;

    IsochoricInvariant<T> ground;
    std::array<IsochoricFibreInvariant<T>, 2> fibres;
    std::array<Derivatives<T>, 2> w;  ///< of Ei
    std::array<Tensor3<T>, 2> B;      ///< dEi/dF
    T c1, d4;                         ///< dpsi/dI1b [Pa], 1 - 3 d

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      Tensor3<T> dP = c1 * ground.change(s, dH) + (slope * dot(s.G, dH)) * s.G + pressure * s.change_of_G(dH);
      for (std::size_t i = 0; i < 2; ++i) {
        dP = dP + (w[i].second * dot(B[i], dH)) * B[i] + (w[i].first * d4) * fibres[i].change(s, dH);
      }
      return dP;
    }
  };

  template <class T, class Mask>
  PLIANT_INLINE T energy(const Tensor3<T>& H, const T& change, const Mask& valid) const {
    const Distortion<T> at(H, change, valid);
    T value = 0.5 * mu * at.i1 + volumetric.energy(at.j);
    for (const auto& family : families) {
      const Vector3<T> f = direction_as<T>(family);
      value += pull.energy(strain(at, T(at.a * (2.0 * dot(f, matvec(at.E, f)) - at.y))));
    }
    return value;
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize_at(const FibreState<T>& s, const VolumetricStress<T>& pressure) const {
    const IsochoricInvariant<T> ground(s);
    const std::array fibres{IsochoricFibreInvariant<T>(s, direction_as<T>(families[0])),
                            IsochoricFibreInvariant<T>(s, direction_as<T>(families[1]))};
    const T d4 = 1.0 - 3.0 * dispersion;
    T c1 = 0.5 * mu;
    std::array<Derivatives<T>, 2> w;
    std::array<Tensor3<T>, 2> B;
    Tensor3<T> P = pressure.value * s.G;
    for (std::size_t i = 0; i < 2; ++i) {
      w[i] = pull.derivatives(strain(s.at, fibres[i].value));
      B[i] = dispersion * ground.B + d4 * fibres[i].B;
      c1 += w[i].first * dispersion;
      P = P + (w[i].first * d4) * fibres[i].B;
    }
    return {{s, pressure.value, pressure.slope, P + c1 * ground.B}, ground, fibres, w, B, c1, d4};
  }

 private:
  /// Ei, of I4b - 1.
  template <class T>
  PLIANT_INLINE T strain(const Distortion<T>& at, const T& i4) const {
    return dispersion * at.i1 + (1.0 - 3.0 * dispersion) * i4;
  }
};

static_assert(ElasticLawTemplate<HolzapfelGasserOgden>);

}  // namespace pliant
