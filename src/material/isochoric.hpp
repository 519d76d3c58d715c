/// Isotropic laws with an energy of the distortion and one of the volume,
///     psi = W(I1b - 3, I2b - 3) + kappa U(J),   I1b = J^(-2/3) I1(C), I2b = J^(-4/3) I2(C), C = F^T F,
/// for which a law only provides W and its derivatives.
///
/// All formulas are written in the Green-Lagrange strain E and j = J - 1, which avoids cancellation when the strain is
/// small: with a = J^(-2/3), x = J^(2/3), D = dev E and (1 + j)^2 = det(I + 2 E)
///     I1b - 3 = a   (2 D:D + (x - 1)^2 (x + 2)   - 4/3 tr^2 E - 8  I3(E))
///     I2b - 3 = a^2 (2 D:D + (x - 1)^2 (2 x + 1) - 4/3 tr^2 E - 16 I3(E))
///     P = F^-T (2 W1 D1 + 2 W2 D2 + kappa J U' I)
///     D1 = 2 a D,   D2 = a^2 (2 D + 4 tr(E) D - 4 dev(E^2))
/// where W1, W2 are W's derivatives: D1, D2 are F^T (dI1b/dF)/2, F^T (dI2b/dF)/2. Source: Holzapfel, Nonlinear Solid
/// Mechanics (Wiley, 2000), section 6.4; the forms without cancellation follow from it.
#pragma once

#include "base/limits.hpp"
#include "base/vector_math.hpp"
#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

/// First and second derivatives of W in i1 = I1b - 3 and i2 = I2b - 3 [Pa].
template <class T>
struct DistortionDerivatives {
  T w1, w2, w11, w12, w22;
};

/// Quantities that depend on F alone.
template <class T>
struct Distortion {
  Tensor3<T> E;
  Tensor3<T> D;  ///< dev E
  T tr;          ///< tr E
  T j;           ///< J - 1; 0 where J <= 0
  T y;           ///< J^(2/3) - 1
  T a;           ///< J^(-2/3)
  T i1, i2;      ///< I1b - 3, I2b - 3

  template <class Mask>
  PLIANT_INLINE Distortion(const Tensor3<T>& H, const T& volume_change, const Mask& valid)
      : E(green_lagrange(H)), tr(trace(E)), j(select(valid, volume_change, T(0.0))) {
    D = add_to_diagonal(E, T(-1.0 / 3.0 * tr));
    y = expm1(T(2.0 / 3.0 * log1p(j)));
    a = 1.0 / (1.0 + y);
    const T shape = 2.0 * dot(D, D) - 4.0 / 3.0 * (tr * tr), I3 = det(E), y2 = y * y;
    i1 = a * (shape + (y2 * (3.0 + y) - 8.0 * I3));
    i2 = (a * a) * (shape + (y2 * (3.0 + 2.0 * y) - 16.0 * I3));
  }
};

/// The parts of a law that do not depend on W. `Law` has `W(i1, i2)`, `derivatives(i1, i2)` (each NaN or +inf where W
/// does not exist), `volumetric`, and `depends_on_i2`, whether W depends on I2b.
template <class Law>
struct IsochoricLaw {
  static constexpr bool is_barrier = true;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  template <class T>
  struct Linearization {
    static constexpr bool depends_on_i2 = Law::depends_on_i2;

    Distortion<T> at;
    Tensor3<T> F, G;  ///< G = F^-T
    Tensor3<T> D1, D2;
    DistortionDerivatives<T> w;
    T slope;       ///< of the Kirchhoff pressure
    Tensor3<T> P;  ///< [Pa]

    /// dP = G dM - G dH^T P, M = F^T P.
    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const Tensor3<T> dE = small_strain(matmul(transpose(F), dH));
      const T t = dot(G, dH);  // dJ / J
      const T dtr = trace(dE);
      const Tensor3<T> dD = add_to_diagonal(dE, T(-1.0 / 3.0 * dtr));
      const T di1 = 2.0 * dot(matmul(G, D1), dH);
      Tensor3<T> dM = (2.0 * w.w1) * ((2.0 * at.a) * dD - (2.0 / 3.0 * t) * D1);
      if constexpr (depends_on_i2) {
        const T di2 = 2.0 * dot(matmul(G, D2), dH);
        const Tensor3<T> X = matmul(at.E, dE);
        const Tensor3<T> dE2 = X + transpose(X);
        const Tensor3<T> inner =
            add_to_diagonal((2.0 + 4.0 * at.tr) * dD + (4.0 * dtr) * at.D - 4.0 * dE2, T(4.0 / 3.0 * trace(dE2)));
        dM = dM + (2.0 * w.w2) * ((at.a * at.a) * inner - (4.0 / 3.0 * t) * D2) +
             (2.0 * (w.w11 * di1 + w.w12 * di2)) * D1 + (2.0 * (w.w12 * di1 + w.w22 * di2)) * D2;
      } else {
        dM = dM + (2.0 * (w.w11 * di1)) * D1;
      }
      return matmul(G, add_to_diagonal(dM, T(slope * t)) - matmul(transpose(dH), P));
    }

    PLIANT_INLINE Tangent<T> tangent() const { return tangent_by_columns<T>(*this); }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    const Distortion<T> at(H, change, valid);
    const T value = law().W(at.i1, at.i2) + law().volumetric.energy(at.j);
    return select(valid, value, T(infinity));
  }

  template <class T>
  PLIANT_INLINE Tensor3<T> P(const Tensor3<T>& H) const {
    return linearize(H).P;
  }

  template <class T>
  PLIANT_INLINE Linearization<T> linearize(const Tensor3<T>& H) const {
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    const Distortion<T> at(H, change, valid);
    const auto pressure = law().volumetric.stress(at.j);
    const DistortionDerivatives<T> w = law().derivatives(at.i1, at.i2);
    const Tensor3<T> F = add_to_diagonal(H, 1.0);
    const Tensor3<T> G = select(valid, T(1.0 / (1.0 + at.j)), T(nan)) * cofactor(F);
    const Tensor3<T> D1 = (2.0 * at.a) * at.D;
    Tensor3<T> D2{}, M = (2.0 * w.w1) * D1;
    if constexpr (Law::depends_on_i2) {
      const Tensor3<T> E2 = matmul(at.E, at.E);
      D2 = (at.a * at.a) * add_to_diagonal((2.0 + 4.0 * at.tr) * at.D - 4.0 * E2, T(4.0 / 3.0 * trace(E2)));
      M = M + (2.0 * w.w2) * D2;
    }
    return {at, F, G, D1, D2, w, pressure.slope, matmul(G, add_to_diagonal(M, pressure.value))};
  }

 private:
  PLIANT_INLINE const Law& law() const { return static_cast<const Law&>(*this); }
};

}  // namespace pliant
