/// Corotated laws: Hooke's law in the frame that rotates with the body, where R is the rotation nearest to F.
///   arap              psi = mu |F - R|^2
///   fixed-corotated   psi = mu |F - R|^2 + lambda/2 (J - 1)^2
/// Sources: Stomakhin, Howes, Schroeder & Teran, "Energetically consistent invertible elasticity", Symp. Computer
/// Animation (2012) (fixed-corotated); Smith, de Goes & Kim, ACM Trans. Graph. 38 (2019) (arap: as rigid as possible;
/// derivatives). In principal stretches, |F - R|^2 = sum_i (l_i - 1)^2. l_3 has the sign of J, so the energy is finite
/// in flat and inverted bodies, and restores them.
///
/// If J < 0 and l_2 + l_3 = 0, R is not unique and psi has a ridge where the second derivative is -inf. Newton's method
/// needs a finite one: the denominator of the twist (P_i + P_j)/(l_i + l_j) is at least `least_sum_of_stretches`. P,
/// and the tangent elsewhere, are exact.
///
/// `arap` resists changes of volume only through changes of length: its Poisson's ratio at rest is 0.
#pragma once

#include "material/spectral.hpp"

namespace pliant {

inline constexpr double least_sum_of_stretches = 1e-3;

template <class S>
struct FixedCorotated {
  static constexpr std::string_view name = "fixed-corotated";
  static constexpr bool is_barrier = false;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  S mu;      ///< shear modulus [Pa]
  S lambda;  ///< first Lame parameter [Pa]

  static FixedCorotated of(const LawData<S>& d) { return {d.parameters[0], d.parameters[1]}; }
  LameOf<S> at_rest() const { return {mu, lambda}; }

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const auto [a, b, c] = principal_stretches(H).strain;
    const T j = volume_change(H);
    return mu * (a * a + b * b + c * c) + 0.5 * lambda * (j * j);
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE SpectralLinearization<T> linearize(const Tensor3<T>& H) const {
    SpectralLinearization<T> result{principal_stretches(H), {}, {}, {}, {}};
    const std::array<T, 3>&strain = result.at.strain, &l = result.at.l;
    const T pressure = lambda * volume_change(H);
    const std::array<T, 3> area{l[1] * l[2], l[2] * l[0], l[0] * l[1]};  // dJ / dl_i
    std::array<T, 3> stress;
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
      stress[k] = 2.0 * mu * strain[k] + pressure * area[k];
      result.normal(k, k) = 2.0 * mu + lambda * (area[k] * area[k]);
      result.normal(i, j) = result.normal(j, i) = lambda * (area[i] * area[j]) + pressure * l[k];
      const T sum = l[i] + l[j];
      const T divisor = select(sum > least_sum_of_stretches, sum, T(least_sum_of_stretches));
      result.shear[k] = 2.0 * mu - pressure * l[k];
      result.twist[k] = 2.0 * mu * (strain[i] + strain[j]) / divisor + pressure * l[k];
    });
    result.P = result.at.assemble(stress);
    return result;
  }
};

template <class S>
struct Arap {
  static constexpr std::string_view name = "arap";
  static constexpr bool is_barrier = false;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  S mu;  ///< shear modulus [Pa]

  static Arap of(const LawData<S>& d) { return {d.parameters[0]}; }
  LameOf<S> at_rest() const { return {mu, S(0.0)}; }

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const auto [a, b, c] = principal_stretches(H).strain;
    return mu * (a * a + b * b + c * c);
  }
  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }
  template <class T>
  PLIANT_INLINE SpectralLinearization<T> linearize(const Tensor3<T>& H) const {
    return FixedCorotated<S>{mu, S(0.0)}.linearize(H);
  }
};

static_assert(ElasticLawTemplate<FixedCorotated> && IsotropicLaw<FixedCorotated<double>>);
static_assert(ElasticLawTemplate<Arap> && IsotropicLaw<Arap<double>>);

}  // namespace pliant
