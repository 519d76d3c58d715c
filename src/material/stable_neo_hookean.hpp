/// Stable neo-Hookean solid: its energy is finite and smooth for every F, including flat and inverted ones, and
/// restores an inverted body.
///   psi = m/2 (I_C - 3) + l/2 (J - 1 - 3/4 m/l)^2 - m/2 ln(I_C + 1) - psi(I),   I_C = tr(F^T F)
///   P = 3/4 m (F - cof F) + l (J - 1) cof F + m tr E / (2 (I_C + 1)) F
/// with m = 4/3 mu, l = lambda + 5/6 mu, which reduce it to Hooke's law with mu and lambda at rest.
/// Source: Smith, de Goes & Kim, "Stable neo-Hookean flesh simulation", ACM Trans. Graph. 37 (2018) 12.
///
/// Computed without cancellation (j = J - 1; for tr E - j see neo_hookean.hpp):
///   psi = 3/4 m (tr E - j) + l/2 j^2 + m/2 (y - ln(1 + y)),  y = tr E / 2
///   tr E - j = j^2/2 - 2 I2(E) - 4 I3(E)
///   F - cof F = H + H^T - tr(H) I - cof H
#pragma once

#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

template <class S>
struct StableNeoHookean {
  static constexpr std::string_view name = "stable-neo-hookean";
  static constexpr bool is_barrier = false;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  S mu;      ///< shear modulus [Pa]
  S lambda;  ///< first Lame parameter [Pa]

  static StableNeoHookean of(const LawData<S>& d) { return {d.parameters[0], d.parameters[1]}; }
  LameOf<S> at_rest() const { return {mu, lambda}; }

  S m() const { return 4.0 / 3.0 * mu; }           ///< [Pa]
  S l() const { return lambda + 5.0 / 6.0 * mu; }  ///< [Pa]

  template <class T>
  struct Linearization {
    S l;              ///< [Pa]
    T of_identity;    ///< factors of dH, [Pa]
    T of_FF;          ///< of (F : dH) F
    T of_d_cofactor;  ///< of d cof F
    Tensor3<T> F, C;  ///< C = cof F
    Tensor3<T> P;     ///< [Pa]

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      // cof F is quadratic in F.
      const Tensor3<T> dC = make_tensor([&](int i, int j) -> T {
        const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
        return (F(a, c) * dH(b, d) + dH(a, c) * F(b, d)) - (F(a, d) * dH(b, c) + dH(a, d) * F(b, c));
      });
      return of_identity * dH + (l * dot(C, dH)) * C + (of_FF * dot(F, dH)) * F + of_d_cofactor * dC;
    }

    PLIANT_INLINE Tangent<T> tangent() const {
      const Tensor3<T> lC = l * C, cF = of_FF * F;
      return make_symmetric_tangent<T>([&](int p, int q) -> T {
        const int i = p / 3, J = p % 3, k = q / 3, L = q % 3;
        T value = lC(i, J) * C(k, L) + cF(i, J) * F(k, L);
        if (p == q) value += of_identity;
        if (i != k && J != L) {  // d (cof F)_iJ / d F_kL = e_ikm e_JLn F_mn
          const T entry = of_d_cofactor * F(3 - i - k, 3 - J - L);
          const bool same_sense = ((k - i + 3) % 3 == 1) == ((L - J + 3) % 3 == 1);
          value = same_sense ? value + entry : value - entry;
        }
        return value;
      });
    }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const Tensor3<T> E = green_lagrange(H);
    const T j = volume_change(H), j2 = j * j;
    const T shape = 0.5 * j2 - 2.0 * second_invariant(E) - 4.0 * det(E);
    return 0.75 * m() * shape + 0.5 * l() * j2 + 0.5 * m() * x_minus_log1p(T(0.5 * trace(E)));
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize(const Tensor3<T>& H) const {
    const T tr = trace(green_lagrange(H)), j = volume_change(H);
    const T s = 1.0 / (2.0 + tr);  // I_C + 1 = 2 (2 + tr E), and tr E >= -3/2
    const Tensor3<T> F = add_to_diagonal(H, 1.0), C = cofactor(F);
    const T softening = 0.25 * m() * (tr * s);
    const Tensor3<T> F_minus_C = add_to_diagonal(H + transpose(H), T(-trace(H))) - cofactor(H);
    const Tensor3<T> P = 0.75 * m() * F_minus_C + (l() * j) * C + softening * F;
    return {l(), 0.75 * m() + softening, 0.5 * m() * (s * s), l() * j - 0.75 * m(), F, C, P};
  }
};

static_assert(ElasticLawTemplate<StableNeoHookean> && IsotropicLaw<StableNeoHookean<double>>);

}  // namespace pliant
