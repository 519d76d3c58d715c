/// Orthotropic law of passive heart muscle: fibres f, sheets s across them.
///   psi = a/(2 b) (exp(b (I1b - 3)) - 1) + sum_{i = f, s} a_i/(2 b_i) (exp(b_i <I4i - 1>^2) - 1)
///         + a_fs/(2 b_fs) (exp(b_fs I8fs^2) - 1) + kappa U(J),   <x> = max(x, 0): fibres do not push
/// I4 and I8 with the change of volume: without it, fibres would resist a change of volume of a slack body.
/// Source: Holzapfel & Ogden, Phil. Trans. R. Soc. A 367 (2009) 3445-3475, equation 5.39.
#pragma once

#include "material/fibre.hpp"

namespace pliant {

template <class S>
struct HolzapfelOgden {
  static constexpr std::string_view name = "holzapfel-ogden";
  static constexpr bool is_barrier = true;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 2;
  static constexpr int energy_degree = 2;
  static constexpr bool has_stretch_limit = true;

  S a, b;                                         ///< of the ground [Pa], [1]
  ExponentialFibre<S> along_f, along_s;           ///< a_f, b_f; a_s, b_s
  ExponentialFibre<S, Compression::stiff> shear;  ///< a_fs, b_fs
  Volumetric<S> volumetric;
  std::array<std::array<S, 3>, 2> directions;

  static HolzapfelOgden of(const LawData<S>& d) {
    const auto& p = d.parameters;
    return {p[0], p[1], {p[2], p[3]}, {p[4], p[5]}, {p[6], p[7]}, {p[8], d.volumetric}, d.directions};
  }

  template <class T>
  struct Linearization {
    FibreState<T> s;
    IsochoricInvariant<T> ground;
    FibreInvariant<T> f4, s4;
    ShearInvariant<T> f8;
    Derivatives<T> w1, wf, ws, w8;
    T pressure, slope;  ///< Kirchhoff, and J d/dJ of it [Pa]
    Tensor3<T> P;       ///< [Pa]

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const auto of = [&](const auto& i, const Derivatives<T>& w) -> Tensor3<T> {
        return (w.second * dot(i.B, dH)) * i.B + w.first * i.change(s, dH);
      };
      return of(ground, w1) + of(f4, wf) + of(s4, ws) + of(f8, w8) + (slope * dot(s.G, dH)) * s.G +
             pressure * s.change_of_G(dH);
    }

    PLIANT_INLINE Tangent<T> tangent() const { return tangent_by_columns<T>(*this); }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    const Distortion<T> at(H, change, valid);
    const Vector3<T> f = direction_as<T>(directions[0]), s = direction_as<T>(directions[1]);
    const Vector3<T> Ef = matvec(at.E, f), Es = matvec(at.E, s);
    const T ground = (0.5 * a / b) * within_exponent(T(b * at.i1), std::numeric_limits<double>::infinity(),
                                                     [](const T& x) -> T { return expm1(x); });
    const T value = ground + along_f.energy(T(2.0 * dot(f, Ef))) + along_s.energy(T(2.0 * dot(s, Es))) +
                    shear.energy(T(2.0 * dot(f, Es))) + volumetric.energy(at.j);
    return select(valid, value, T(std::numeric_limits<double>::infinity()));
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const FibreState<T> state(H, change, change > -1.0);
    const Vector3<T> f = direction_as<T>(directions[0]), s = direction_as<T>(directions[1]);
    const IsochoricInvariant<T> ground(state);
    const FibreInvariant<T> f4(state, f), s4(state, s);
    const ShearInvariant<T> f8(state, f, s);
    const T w = 0.5 * a *
                within_exponent(T(b * ground.value), std::numeric_limits<double>::quiet_NaN(),
                                [](const T& x) -> T { return exp(x); });
    const Derivatives<T> w1{w, T(b * w)};
    const Derivatives<T> wf = along_f.derivatives(f4.value), ws = along_s.derivatives(s4.value);
    const Derivatives<T> w8 = shear.derivatives(f8.value);
    const auto pressure = volumetric.stress(state.at.j);
    const Tensor3<T> P =
        w1.first * ground.B + wf.first * f4.B + ws.first * s4.B + w8.first * f8.B + pressure.value * state.G;
    return {state, ground, f4, s4, f8, w1, wf, ws, w8, pressure.value, pressure.slope, P};
  }
};

static_assert(ElasticLawTemplate<HolzapfelOgden>);

}  // namespace pliant
