/// Orthotropic law of passive heart muscle with fibres f and sheets s normal to them.
///   psi = a/(2 b) (exp(b (I1b - 3)) - 1) + sum_{i = f, s} a_i/(2 b_i) (exp(b_i <I4i - 1>^2) - 1)
///         + a_fs/(2 b_fs) (exp(b_fs I8fs^2) - 1) + kappa U(J),   <x> = max(x, 0): fibres do not push
/// I4 and I8 include the change of volume; without it, fibres would resist the change of volume of a slack body.
/// Source: Holzapfel & Ogden, Phil. Trans. R. Soc. A 367 (2009) 3445-3475, equation 5.39.
#pragma once

#include "material/fibre.hpp"

namespace pliant {

template <class S>
struct HolzapfelOgden : FibreLaw<HolzapfelOgden<S>> {
  static constexpr std::string_view name = "holzapfel-ogden";
  static constexpr int num_directions = 2;

  S a, b;                                         ///< of the ground matrix [Pa], [1]
  ExponentialFibre<S> along_f, along_s;           ///< a_f, b_f; a_s, b_s
  ExponentialFibre<S, Compression::stiff> shear;  ///< a_fs, b_fs
  Volumetric<S> volumetric;
  std::array<std::array<S, 3>, 2> directions;

  static HolzapfelOgden of(const LawData<S>& d) {
    const auto& p = d.parameters;
    return {{}, p[0], p[1], {p[2], p[3]}, {p[4], p[5]}, {p[6], p[7]}, {p[8], d.volumetric}, d.directions};
  }

  template <class T>
  struct Linearization : FibreLinearization<Linearization<T>, T> {
    using Base = FibreLinearization<Linearization, T>;
    using Base::s, Base::pressure, Base::slope;

    IsochoricInvariant<T> ground;
    FibreInvariant<T> f4, s4;
    ShearInvariant<T> f8;
    Derivatives<T> w1, wf, ws, w8;

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const auto of = [&](const auto& i, const Derivatives<T>& w) -> Tensor3<T> {
        return (w.second * dot(i.B, dH)) * i.B + w.first * i.change(s, dH);
      };
      return of(ground, w1) + of(f4, wf) + of(s4, ws) + of(f8, w8) + (slope * dot(s.G, dH)) * s.G +
             pressure * s.change_of_G(dH);
    }
  };

  template <class T, class Mask>
  PLIANT_INLINE T energy(const Tensor3<T>& H, const T& change, const Mask& valid) const {
    const Distortion<T> at(H, change, valid);
    const Vector3<T> f = direction_as<T>(directions[0]), s = direction_as<T>(directions[1]);
    const Vector3<T> Ef = matvec(at.E, f), Es = matvec(at.E, s);
    const T ground = (0.5 * a / b) * within_exponent(T(b * at.i1), infinity, [](const T& x) -> T { return expm1(x); });
    return ground + along_f.energy(T(2.0 * dot(f, Ef))) + along_s.energy(T(2.0 * dot(s, Es))) +
           shear.energy(T(2.0 * dot(f, Es))) + volumetric.energy(at.j);
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize_at(const FibreState<T>& state, const VolumetricStress<T>& pressure) const {
    const Vector3<T> f = direction_as<T>(directions[0]), s = direction_as<T>(directions[1]);
    const IsochoricInvariant<T> ground(state);
    const FibreInvariant<T> f4(state, f), s4(state, s);
    const ShearInvariant<T> f8(state, f, s);
    const T w = 0.5 * a * within_exponent(T(b * ground.value), nan, [](const T& x) -> T { return exp(x); });
    const Derivatives<T> w1{w, T(b * w)};
    const Derivatives<T> wf = along_f.derivatives(f4.value), ws = along_s.derivatives(s4.value);
    const Derivatives<T> w8 = shear.derivatives(f8.value);
    const Tensor3<T> P =
        w1.first * ground.B + wf.first * f4.B + ws.first * s4.B + w8.first * f8.B + pressure.value * state.G;
    return {{state, pressure.value, pressure.slope, P}, ground, f4, s4, f8, w1, wf, ws, w8};
  }
};

static_assert(ElasticLawTemplate<HolzapfelOgden>);

}  // namespace pliant
