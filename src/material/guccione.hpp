/// Transversely isotropic exponential law of passive heart muscle.
///   psi = C/2 (exp Q - 1) + kappa U(J)
///   Q = bf Eff^2 + bt (Ess^2 + Enn^2 + 2 Esn^2) + 2 bfs (Efs^2 + Efn^2)
/// With g = E f - Eff f and T = E - f (x) g - g (x) f - Eff f (x) f, the parts of E between the fibre and its normal
/// plane and within that plane, Q = bf Eff^2 + 2 bfs g.g + bt T:T needs no second direction. Then
///   S = C exp(Q) A,  A = bf Eff f (x) f + bfs (f (x) g + g (x) f) + bt T
///   dS = C exp(Q) (A(dE) + 2 (A : dE) A),  P = F S + kappa J U' F^-T
/// Sources: Guccione, McCulloch & Waldman, J. Biomech. Eng. 113 (1991) 42-55; Land et al., Proc. R. Soc. A 471 (2015)
/// 20150641, equation 2.3.
#pragma once

#include "material/fibre.hpp"

namespace pliant {

template <class S>
struct Guccione : FibreLaw<Guccione<S>> {
  static constexpr std::string_view name = "guccione";
  static constexpr int num_directions = 1;

  S C;            ///< [Pa]
  S bf, bt, bfs;  ///< exponents along the fibres, across them, and of shear between both
  Volumetric<S> volumetric;
  std::array<S, 3> fibre;

  static Guccione of(const LawData<S>& d) {
    const auto& p = d.parameters;
    return {{}, p[0], p[1], p[2], p[3], {p[4], d.volumetric}, d.directions[0]};
  }

  template <class T>
  struct Linearization : FibreLinearization<Linearization<T>, T> {
    using Base = FibreLinearization<Linearization, T>;
    using Base::s, Base::pressure, Base::slope;

    Vector3<T> f;
    T scale;  ///< C exp Q [Pa]
    T bf, bt, bfs;
    Tensor3<T> A, S2;  ///< S2: second Piola-Kirchhoff stress without its volumetric part [Pa]

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const Tensor3<T> dE = small_strain(matmul(transpose(s.F), dH));
      const Tensor3<T> dS = scale * (weighted(dE, f, {bf, bt, bfs}) + (2.0 * dot(A, dE)) * A);
      return matmul(dH, S2) + matmul(s.F, dS) + (slope * dot(s.G, dH)) * s.G + pressure * s.change_of_G(dH);
    }
  };

  template <class T, class Mask>
  PLIANT_INLINE T energy(const Tensor3<T>& H, const T& change, const Mask& valid) const {
    const Tensor3<T> E = green_lagrange(H);
    const T j = select(valid, change, T(0.0)), Q = dot(weighted(E, direction_as<T>(fibre), exponents<T>()), E);
    return (0.5 * C) * within_exponent(Q, infinity, [](const T& x) -> T { return expm1(x); }) + volumetric.energy(j);
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize_at(const FibreState<T>& s, const VolumetricStress<T>& pressure) const {
    const Vector3<T> f = direction_as<T>(fibre);
    const Tensor3<T> A = weighted(s.at.E, f, exponents<T>());
    const T scale = C * within_exponent(T(dot(A, s.at.E)), nan, [](const T& x) -> T { return exp(x); });
    const Tensor3<T> S2 = scale * A;
    return {{s, pressure.value, pressure.slope, matmul(s.F, S2) + pressure.value * s.G},
            f,
            scale,
            T(bf),
            T(bt),
            T(bfs),
            A,
            S2};
  }

 private:
  template <class T>
  struct Exponents {
    T f, t, fs;
  };
  template <class T>
  PLIANT_INLINE Exponents<T> exponents() const {
    return {T(bf), T(bt), T(bfs)};
  }

  /// A as a function of E; Q = A : E.
  template <class T>
  PLIANT_INLINE static Tensor3<T> weighted(const Tensor3<T>& E, const Vector3<T>& f, const Exponents<T>& b) {
    const Vector3<T> Ef = matvec(E, f);
    const T Eff = dot(f, Ef);
    const Vector3<T> g{Ef[0] - Eff * f[0], Ef[1] - Eff * f[1], Ef[2] - Eff * f[2]};
    const Tensor3<T> between = outer(f, g) + outer(g, f), along = Eff * outer(f, f);
    return b.f * along + b.fs * between + b.t * (E - between - along);
  }
};

static_assert(ElasticLawTemplate<Guccione>);

}  // namespace pliant
