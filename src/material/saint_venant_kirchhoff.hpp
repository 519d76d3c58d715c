/// Saint Venant-Kirchhoff: Hooke's law between E and S, for large rotations and small strains.
///   psi = mu E:E + lambda/2 (tr E)^2,  E = (F^T F - I) / 2
///   P = F S,  S = 2 mu E + lambda tr(E) I
///   d P_iJ / d F_kL = d_ik S_JL + lambda F_iJ F_kL + mu (F_iL F_kJ + (F F^T)_ik d_JL)
/// Source: Holzapfel, Nonlinear Solid Mechanics (Wiley, 2000), section 6.5.
/// It softens under compression (a bar collapses below a stretch of 0.577) and does not resist inversion.
#pragma once

#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

struct SaintVenantKirchhoff {
  static constexpr std::string_view name = "saint-venant-kirchhoff";
  static constexpr bool needs_positive_volume = false;
  static constexpr bool constant_tangent = false;

  double mu;      ///< shear modulus [Pa]
  double lambda;  ///< first Lame parameter [Pa]

  template <class T>
  struct Linearization {
    double mu;      ///< [Pa]
    double lambda;  ///< [Pa]
    Tensor3<T> F;
    Tensor3<T> S;  ///< second Piola-Kirchhoff stress [Pa]
    Tensor3<T> P;  ///< [Pa]

    /// dP = dH S + F dS,  dS = 2 mu dE + lambda tr(dE) I,  dE = (F^T dH + dH^T F) / 2.
    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const Tensor3<T> dE = small_strain(matmul(transpose(F), dH));
      const Tensor3<T> dS = add_to_diagonal(2.0 * mu * dE, lambda * trace(dE));
      return matmul(dH, S) + matmul(F, dS);
    }

    PLIANT_INLINE Tangent<T> tangent() const {
      const Tensor3<T> B = matmul(F, transpose(F));
      return make_symmetric_tangent<T>([&](int p, int q) -> T {
        const int i = p / 3, J = p % 3, k = q / 3, L = q % 3;
        T value = lambda * F(i, J) * F(k, L) + mu * (F(i, L) * F(k, J));
        if (i == k) value += S(J, L);
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
    const Tensor3<T> S = add_to_diagonal(2.0 * mu * E, lambda * trace(E));
    return {mu, lambda, add_to_diagonal(H, 1.0), S, S + matmul(H, S)};
  }
};

static_assert(ElasticLaw<SaintVenantKirchhoff>);

}  // namespace pliant
