/// Ogden's solid with up to four terms, an energy of the isochoric stretches.
///   psi = sum_p 2 mu_p / alpha_p^2 (l1b^alpha_p + l2b^alpha_p + l3b^alpha_p - 3) + kappa U(J),   l_ib = J^(-1/3) l_i
/// Sources: Ogden, Proc. R. Soc. Lond. A 326 (1972) 565-584; Holzapfel, Nonlinear Solid Mechanics (Wiley, 2000),
/// section 6.5. The shear modulus at rest is sum_p mu_p; Ogden's own mu_p equals 2 mu_p / alpha_p in this notation.
/// alpha_p = 2 is the neo-Hookean solid; alpha_p = 0 is the limit, Hencky's energy mu_p sum_i (ln l_ib)^2.
///
/// With e_i = ln l_ib, whose sum is 0, phi1(x) = (exp(x) - 1)/x and phi2(x) = (exp(x) - 1 - x)/x^2, there is no
/// cancellation:
///   psi = sum_p 2 mu_p sum_i e_i^2 phi2(alpha_p e_i) + kappa U(J)
///   tau_i = t_i - (t_1 + t_2 + t_3)/3 + kappa J U',  t_i = sum_p 2 mu_p e_i phi1(alpha_p e_i),  P_i = tau_i / l_i
///   l_i l_j (P_i - P_j)/(l_i - l_j) = sum_p 2 mu_p exp(alpha_p e_j) phi1(alpha_p d)/phi1(d) - tau_j,  d = e_i - e_j
#pragma once

#include "base/vector_math.hpp"
#include "material/spectral.hpp"

namespace pliant {

template <class S>
struct Ogden {
  static constexpr std::string_view name = "ogden";
  static constexpr bool is_barrier = true;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;
  static constexpr std::size_t most_terms = 4;

  std::array<S, most_terms> mu;     ///< [Pa]
  std::array<S, most_terms> alpha;  ///< [1]
  std::size_t num_terms;            ///< terms in use; the others are 0
  Volumetric<S> volumetric;

  static Ogden of(const LawData<S>& d) {
    Ogden law{{}, {}, 0, {d.parameters[2 * most_terms], d.volumetric}};
    for (std::size_t p = 0; p < most_terms; ++p) {
      law.mu[p] = d.parameters[2 * p];
      law.alpha[p] = d.parameters[2 * p + 1];
      if (any_of(law.mu[p] != 0.0)) law.num_terms = p + 1;
    }
    return law;
  }
  LameOf<S> at_rest() const {
    const S sum = mu[0] + mu[1] + mu[2] + mu[3];
    return {sum, volumetric.kappa - 2.0 / 3.0 * sum};
  }

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto exists = change > -1.0;
    const auto [at, valid, e] = state(exists, H);
    T value = volumetric.energy(select(valid, change, T(0.0)));
    for (std::size_t p = 0; p < num_terms; ++p) {
      for (std::size_t i = 0; i < 3; ++i) value += 2.0 * mu[p] * ((e[i] * e[i]) * phi2(T(alpha[p] * e[i])));
    }
    return select(valid, value, T(std::numeric_limits<double>::infinity()));
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    const Stress<T> s = stress(H);
    return s.at.assemble(s.P);
  }

  template <class T>
  PLIANT_INLINE SpectralLinearization<T> linearize(const Tensor3<T>& H) const {
    const Stress<T> s = stress(H);
    SpectralLinearization<T> result{s.at, {}, {}, {}, s.at.assemble(s.P)};
    const std::array<T, 3>& l = s.at.l;
    // d tau_i / d ln l_j = k_i d_ij - (k_i + k_j)/3 + (k_1 + k_2 + k_3)/9 + slope,  k_i = d t_i / d e_i
    std::array<T, 3> k{};
    for (std::size_t p = 0; p < num_terms; ++p) {
      for (std::size_t i = 0; i < 3; ++i) k[i] += 2.0 * mu[p] * s.power[p][i];
    }
    const T common = (k[0] + k[1] + k[2]) / 9.0 + s.slope;
    unroll<3>([&](auto m) __attribute__((always_inline)) {
      constexpr int i = (m + 1) % 3, j = (m + 2) % 3;
      result.normal(m, m) = (common + k[m] / 3.0 - s.tau[m]) / (l[m] * l[m]);
      const T both = 1.0 / (l[i] * l[j]);
      result.normal(i, j) = result.normal(j, i) = (common - (k[i] + k[j]) / 3.0) * both;
      const T d = s.e[i] - s.e[j];
      T quotient = 0.0;
      for (std::size_t p = 0; p < num_terms; ++p) {
        // From the larger of the powers: exp(alpha e_j) phi1(alpha d) = exp(alpha e_i) phi1(-alpha d).
        const T x = alpha[p] * d;
        const auto rises = x > 0.0;
        quotient += 2.0 * mu[p] * (select(rises, s.power[p][i], s.power[p][j]) * phi1(select(rises, T(-x), x)));
      }
      result.shear[m] = (quotient / phi1(d) - s.tau[j]) * both;
      result.twist[m] = (s.P[i] + s.P[j]) / (l[i] + l[j]);
    });
    return result;
  }

 private:
  /// The state in lanes where the law exists; the others are at rest.
  template <class T, class Mask>
  struct State {
    PrincipalStretches<T> at;
    Mask valid;
    std::array<T, 3> e;
  };

  template <class T, class Mask>
  PLIANT_INLINE State<T, Mask> state(const Mask& exists, const Tensor3<T>& H) const {
    State<T, Mask> s{
        principal_stretches(make_tensor([&](int i, int J) -> T { return select(exists, H(i, J), T(0.0)); })),
        exists,
        {}};
    s.valid = exists && s.at.strain[2] > -1.0;  // J > 0, but so little that the last stretch is lost in rounding
    s.at.strain[2] = select(s.valid, s.at.strain[2], T(0.0));
    s.at.l[2] = 1.0 + s.at.strain[2];
    for (std::size_t i = 0; i < 3; ++i) s.e[i] = log1p(s.at.strain[i]);
    const T mean = (s.e[0] + s.e[1] + s.e[2]) / 3.0;
    for (T& e : s.e) e -= mean;
    return s;
  }

  template <class T>
  struct Stress {
    PrincipalStretches<T> at;
    std::array<T, 3> e;
    std::array<std::array<T, 3>, most_terms> power;  ///< exp(alpha_p e_i) = l_ib^alpha_p
    std::array<T, 3> tau;                            ///< principal Kirchhoff stresses [Pa]; NaN where J <= 0
    std::array<T, 3> P;                              ///< tau_i / l_i [Pa]
    T slope;                                         ///< J d/dJ of kappa J U' [Pa]
  };

  template <class T>
  PLIANT_INLINE Stress<T> stress(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto exists = change > -1.0;
    const auto [at, valid, e] = state(exists, H);
    const auto pressure = volumetric.stress(select(valid, change, T(0.0)));
    Stress<T> s{at, e, {}, {}, {}, pressure.slope};
    for (std::size_t p = 0; p < num_terms; ++p) {
      for (std::size_t i = 0; i < 3; ++i) {
        const T x = alpha[p] * e[i], growth = phi1(x);
        s.power[p][i] = 1.0 + x * growth;
        s.tau[i] += 2.0 * mu[p] * (e[i] * growth);
      }
    }
    const T shift = pressure.value - (s.tau[0] + s.tau[1] + s.tau[2]) / 3.0;
    for (std::size_t i = 0; i < 3; ++i) {
      s.tau[i] = select(valid, T(s.tau[i] + shift), T(std::numeric_limits<double>::quiet_NaN()));
      s.P[i] = s.tau[i] / at.l[i];
    }
    return s;
  }
};

static_assert(ElasticLawTemplate<Ogden> && IsotropicLaw<Ogden<double>>);

}  // namespace pliant
