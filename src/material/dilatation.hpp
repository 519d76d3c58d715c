/// Laws evaluated at a volume ratio theta other than J = det F: Psi(F, theta) = psi(Fbar), Fbar = (theta/J)^(1/3) F.
/// With them the volume can be averaged and the distortion kept.
///
/// With a = (theta/J)^(1/3), G = F^-T, Pb = P(Fbar), Ab = dP/dF(Fbar), B = Ab : Fbar, tau = Pb : Fbar, s = Fbar : B,
///     c = a (Pb + B),  m = (tau + s) / 3
///     Psi_F              = a Pb - tau/3 G
///     Psi_theta          = tau / (3 theta)
///     Psi_FF             = a^2 Ab - (c (x) G + G (x) c)/3 + m/3 G (x) G + tau/3 G_iL G_kJ
///     Psi_F,theta        = (c - m G) / (3 theta)
///     Psi_theta,theta    = (s - 2 tau) / (9 theta^2)
/// because dFbar = a (dF - (G : dF)/3 F) + dtheta/(3 theta) Fbar. There is no cancellation when H is small, because
/// Hbar = Fbar - I is computed from H and theta - J. Source: Simo, Taylor & Pister, Comput. Methods Appl. Mech. Eng. 51
/// (1985) 177-208.
#pragma once

#include "base/vector_math.hpp"
#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

/// F with another volume ratio.
template <class T>
struct Dilated {
  Tensor3<T> F;
  Tensor3<T> G;  ///< F^-T
  Tensor3<T> H;  ///< Fbar - I
  T J;
  T theta;
  T a;  ///< (theta/J)^(1/3)
};

/// H = F - I, its j = J - 1 > -1, and theta_change = theta - 1 > -1.
template <class T>
PLIANT_INLINE Dilated<T> dilated(const Tensor3<T>& H, const T& j, const T& theta_change) {
  const T J = 1.0 + j;
  const T growth = expm1(T(log1p(T((theta_change - j) / J)) / 3.0));  // a - 1
  const Tensor3<T> F = add_to_diagonal(H, 1.0);
  return {F, T(1.0 / J) * cofactor(F), H + growth * F, J, 1.0 + theta_change, 1.0 + growth};
}

/// Fbar(F + dF, theta + dtheta) - Fbar(F, theta), accurate relative to the change; dJ is the change of J.
template <class T>
PLIANT_INLINE Tensor3<T> dilated_change(const Dilated<T>& at, const Tensor3<T>& dF, const T& dJ, const T& dtheta) {
  const T ratio = (dtheta * at.J - dJ * at.theta) / (at.theta * (at.J + dJ));
  const T growth = expm1(T(log1p(ratio) / 3.0));
  return at.a * (dF + growth * (at.F + dF));
}

/// First derivatives of Psi, from Pb.
template <class T>
struct DilatedStress {
  Tensor3<T> distortion;  ///< Psi_F [Pa]
  T pressure;             ///< Psi_theta [Pa]

  PLIANT_INLINE DilatedStress(const Dilated<T>& at, const Tensor3<T>& Pb) {
    const T tau = dot(Pb, add_to_diagonal(at.H, 1.0));
    distortion = at.a * Pb - T(tau / 3.0) * at.G;
    pressure = tau / (3.0 * at.theta);
  }
};

/// Second derivatives of Psi + p J, from Pb and Ab, with a given p [Pa].
template <class T>
struct DilatedTangent {
  Tangent<T> FF;
  Tensor3<T> coupling;
  T thetatheta;

  PLIANT_INLINE DilatedTangent(const Dilated<T>& at, const Tensor3<T>& Pb, const Tangent<T>& Ab, const T& p) {
    const Tensor3<T> Fbar = add_to_diagonal(at.H, 1.0);
    Tensor3<T> c{};
    for (std::size_t k = 0; k < 9; ++k) {
      for (std::size_t l = 0; l < 9; ++l) c.a[k] += Ab[9 * k + l] * Fbar.a[l];
    }
    const T tau = dot(Pb, Fbar), s = dot(Fbar, c), m = (tau + s) / 3.0;
    c = at.a * (c + Pb);
    coupling = T(1.0 / (3.0 * at.theta)) * (c - m * at.G);
    thetatheta = (s - 2.0 * tau) / (9.0 * (at.theta * at.theta));
    const T pJ = p * at.J, same = m / 3.0 + pJ, crossed = tau / 3.0 - pJ, a2 = at.a * at.a;
    for (std::size_t k = 0; k < 9; ++k) {
      for (std::size_t l = k; l < 9; ++l) {
        const int i = static_cast<int>(k) / 3, J = static_cast<int>(k) % 3, n = static_cast<int>(l) / 3,
                  L = static_cast<int>(l) % 3;
        FF[9 * k + l] = FF[9 * l + k] = a2 * Ab[9 * k + l] - (c.a[k] * at.G.a[l] + at.G.a[k] * c.a[l]) / 3.0 +
                                        same * (at.G.a[k] * at.G.a[l]) + crossed * (at.G(i, L) * at.G(n, J));
      }
    }
  }
};

}  // namespace pliant
