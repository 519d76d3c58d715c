/// Linear elasticity (Hooke), for small strains and small rotations.
///   psi = mu eps:eps + lambda/2 (tr eps)^2,  eps = (H + H^T) / 2
///   P = 2 mu eps + lambda tr(eps) I
///   d P_iJ / d F_kL = mu (d_ik d_JL + d_iL d_Jk) + lambda d_iJ d_kL
#pragma once

#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

template <class S>
struct Linear {
  static constexpr std::string_view name = "linear";
  static constexpr bool is_barrier = false;
  static constexpr bool constant_tangent = true;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  S mu;      ///< shear modulus [Pa]
  S lambda;  ///< first Lame parameter [Pa]

  static Linear of(const LawData<S>& d) { return {d.parameters[0], d.parameters[1]}; }
  LameOf<S> at_rest() const { return {mu, lambda}; }

  template <class T>
  struct Linearization {
    S mu;          ///< [Pa]
    S lambda;      ///< [Pa]
    Tensor3<T> P;  ///< [Pa]

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const { return Linear<S>{mu, lambda}.P(dH); }

    PLIANT_INLINE Tangent<T> tangent() const {
      return make_symmetric_tangent<T>([&](int p, int q) -> T {
        const int i = p / 3, J = p % 3, k = q / 3, L = q % 3;
        return T((p == q ? mu : S(0.0)) + (i == L && J == k ? mu : S(0.0)) + (i == J && k == L ? lambda : S(0.0)));
      });
    }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const Tensor3<T> eps = small_strain(H);
    const T tr = trace(eps);
    return mu * dot(eps, eps) + 0.5 * lambda * (tr * tr);
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return add_to_diagonal(2.0 * mu * small_strain(H), lambda * trace(H));
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize(const Tensor3<T>& H) const {
    return {mu, lambda, P(H)};
  }
};

static_assert(ElasticLawTemplate<Linear> && IsotropicLaw<Linear<double>>);

}  // namespace pliant
