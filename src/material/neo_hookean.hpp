/// Compressible neo-Hookean solid, for large rotations and large strains; its energy is a barrier against inversion.
///   psi = mu/2 (tr(F^T F) - 3) - mu ln J + lambda/2 (ln J)^2
///   P = mu (F - F^-T) + lambda ln(J) F^-T
///   d P_iJ / d F_kL = mu d_ik d_JL + (mu - lambda ln J) G_iL G_kJ + lambda G_iJ G_kL,  G = F^-T
/// Source: Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (Cambridge, 2nd ed. 2008),
/// section 6.4.3.
///
/// As written, psi and P are small differences of large numbers when strains are small. The code computes instead, with
/// j = J - 1:
///   P = F^-T (2 mu E + lambda log1p(j) I)                    since F^-T (F^T F - I) = F - F^-T
///   psi = mu (tr E - ln J) + lambda/2 log1p(j)^2             since tr(F^T F) - 3 = 2 tr E
///   tr E - ln J = j^2/2 - 2 I2(E) - 4 I3(E) + (j - log1p(j))
/// The last line follows from (1 + j)^2 = det(I + 2 E) = 1 + 2 tr E + 4 I2(E) + 8 I3(E), where I2 and I3 are the second
/// and third invariants. Every term is of second order, like the sum, and all but j depend on E alone. The energy of a
/// rotated, hardly strained body is therefore as accurate as that of a body at rest.
#pragma once

#include "material/kinematics.hpp"
#include "material/law.hpp"

#include <limits>

namespace pliant {

template <class S>
struct NeoHookean {
  static constexpr std::string_view name = "neo-hookean";
  static constexpr bool is_barrier = true;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  S mu;      ///< shear modulus [Pa]
  S lambda;  ///< first Lame parameter [Pa]

  static NeoHookean of(const LawData<S>& d) { return {d.parameters[0], d.parameters[1]}; }
  LameOf<S> at_rest() const { return {mu, lambda}; }

  template <class T>
  struct Linearization {
    S mu;          ///< [Pa]
    S lambda;      ///< [Pa]
    T log_J;       ///< NaN where J <= 0
    Tensor3<T> G;  ///< F^-T
    Tensor3<T> P;  ///< [Pa]

    /// dP = mu dH + (mu - lambda ln J) G dH^T G + lambda (G : dH) G.
    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const T c = mu - lambda * log_J;
      return mu * dH + c * matmul(G, matmul(transpose(dH), G)) + (lambda * dot(G, dH)) * G;
    }

    PLIANT_INLINE Tangent<T> tangent() const {
      const T c = mu - lambda * log_J;
      const Tensor3<T> cG = c * G;
      const Tensor3<T> lambda_G = lambda * G;
      return make_symmetric_tangent<T>([&](int p, int q) -> T {
        const int i = p / 3, J = p % 3, k = q / 3, L = q % 3;
        const T value = cG(i, L) * G(k, J) + lambda_G(i, J) * G(k, L);
        return p == q ? T(value + mu) : value;
      });
    }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const Tensor3<T> E = green_lagrange(H);
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    const T j = select(valid, change, T(0.0));
    const T tr_E_minus_log_J = (0.5 * (j * j) - 2.0 * second_invariant(E)) - 4.0 * det(E) + x_minus_log1p(j);
    const T log_J = log1p(j);
    const T value = mu * tr_E_minus_log_J + 0.5 * lambda * (log_J * log_J);
    return select(valid, value, T(std::numeric_limits<double>::infinity()));
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    const T j = select(valid, change, T(0.0));
    const T log_J = select(valid, T(log1p(j)), T(std::numeric_limits<double>::quiet_NaN()));
    const Tensor3<T> G = T(1.0 / (1.0 + j)) * cofactor(add_to_diagonal(H, 1.0));
    const Tensor3<T> M = add_to_diagonal(2.0 * mu * green_lagrange(H), lambda * log_J);
    return {mu, lambda, log_J, G, matmul(G, M)};
  }
};

static_assert(ElasticLawTemplate<NeoHookean> && IsotropicLaw<NeoHookean<double>>);

}  // namespace pliant
