/// Saint Venant-Kirchhoff solid: Hooke's law between E and S, for large rotations and small strains.
///   psi = mu E:E + lambda/2 (tr E)^2,  E = (F^T F - I) / 2
///   P = F S,  S = 2 mu E + lambda tr(E) I
///   d P_iJ / d F_kL = d_ik S_JL + lambda F_iJ F_kL + mu (F_iL F_kJ + (F F^T)_ik d_JL)
/// Source: Holzapfel, Nonlinear Solid Mechanics (Wiley, 2000), section 6.5.
/// It softens under compression (a bar collapses below a stretch of 0.577) and does not resist inversion.
#pragma once

#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

template <class S>
struct SaintVenantKirchhoff {
  static constexpr std::string_view name = "saint-venant-kirchhoff";
  static constexpr bool is_barrier = false;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 4;

  S mu;      ///< shear modulus [Pa]
  S lambda;  ///< first Lame parameter [Pa]

  static SaintVenantKirchhoff of(const LawData<S>& d) { return {d.parameters[0], d.parameters[1]}; }
  LameOf<S> at_rest() const { return {mu, lambda}; }

  template <class T>
  struct Linearization {
    S mu;      ///< [Pa]
    S lambda;  ///< [Pa]
    Tensor3<T> F;
    Tensor3<T> stress;  ///< second Piola-Kirchhoff stress [Pa]
    Tensor3<T> P;       ///< [Pa]

    /// dP = dH S + F dS,  dS = 2 mu dE + lambda tr(dE) I,  dE = (F^T dH + dH^T F) / 2.
    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const Tensor3<T> dE = small_strain(matmul(transpose(F), dH));
      const Tensor3<T> dS = add_to_diagonal(2.0 * mu * dE, lambda * trace(dE));
      return matmul(dH, stress) + matmul(F, dS);
    }

    PLIANT_INLINE Tangent<T> tangent() const {
      const Tensor3<T> B = matmul(F, transpose(F));
      return make_symmetric_tangent<T>([&](int p, int q) -> T {
        const int i = p / 3, J = p % 3, k = q / 3, L = q % 3;
        T value = lambda * F(i, J) * F(k, L) + mu * (F(i, L) * F(k, J));
        if (i == k) value += stress(J, L);
        if (J == L) value += mu * B(i, k);
        return value;
      });
    }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const Tensor3<T> E = green_lagrange(H);
    const T tr = trace(E);
    return mu * dot(E, E) + 0.5 * lambda * (tr * tr);
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize(const Tensor3<T>& H) const {
    const Tensor3<T> E = green_lagrange(H);
    const Tensor3<T> stress = add_to_diagonal(2.0 * mu * E, lambda * trace(E));
    return {mu, lambda, add_to_diagonal(H, 1.0), stress, stress + matmul(H, stress)};
  }
};

static_assert(ElasticLawTemplate<SaintVenantKirchhoff> && IsotropicLaw<SaintVenantKirchhoff<double>>);

}  // namespace pliant
