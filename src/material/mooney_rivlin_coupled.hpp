/// Compressible Mooney-Rivlin solid whose invariants are those of C itself, not of its isochoric part.
///   psi = c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + lambda/2 (ln J)^2
/// At rest, mu = 2 (c1 + c2) and Lame's first parameter is lambda + 4 c2. With c2 = 0 it is neo_hookean.hpp.
/// Sources: Ciarlet & Geymonat, C. R. Acad. Sci. Paris II 295 (1982) 423-426 (the form); Maas et al., FEBio Theory
/// Manual, "Coupled Mooney-Rivlin".
///
/// Without cancellation at small strain, with j = J - 1, t = tr E - ln J (see neo_hookean.hpp) and C = I + 2 E:
///   psi = 2 c1 t + 4 c2 (t + I2(E)) + lambda/2 log1p(j)^2            since I2(C) - 3 = 4 tr E + 4 I2(E)
///   t   = j^2/2 - 2 I2(E) - 4 I3(E) + (j - log1p(j))
///   P   = F^-T M,  M = C S = 4 (c1 + c2) E + 4 c2 (tr(E) I + 2 tr(E) E - 2 E^2) + lambda log1p(j) I
///   dP  = F^-T (dM - dH^T P)
#pragma once

#include "base/limits.hpp"
#include "material/kinematics.hpp"
#include "material/law.hpp"

namespace pliant {

template <class S>
struct MooneyRivlinCoupled {
  static constexpr std::string_view name = "mooney-rivlin-coupled";
  static constexpr bool is_barrier = true;
  static constexpr bool constant_tangent = false;
  static constexpr int num_directions = 0;
  static constexpr int energy_degree = 2;

  S c1, c2, lambda;  ///< [Pa]

  static MooneyRivlinCoupled of(const LawData<S>& d) { return {d.parameters[0], d.parameters[1], d.parameters[2]}; }
  LameOf<S> at_rest() const { return {2.0 * (c1 + c2), lambda + 4.0 * c2}; }

  template <class T>
  struct Linearization {
    S c1, c2, lambda;    ///< [Pa]
    Tensor3<T> E, F, G;  ///< G = F^-T, NaN where J <= 0
    Tensor3<T> P;        ///< [Pa]

    PLIANT_INLINE Tensor3<T> operator()(const Tensor3<T>& dH) const {
      const Tensor3<T> dE = small_strain(matmul(transpose(F), dH)), X = matmul(E, dE);
      const T tr = trace(E), dtr = trace(dE);
      const Tensor3<T> dM =
          (4.0 * (c1 + c2) + 8.0 * c2 * tr) * dE + (8.0 * c2 * dtr) * E - (8.0 * c2) * (X + transpose(X));
      return matmul(G, add_to_diagonal(dM, T(4.0 * c2 * dtr + lambda * dot(G, dH))) - matmul(transpose(dH), P));
    }

    PLIANT_INLINE Tangent<T> tangent() const { return tangent_by_columns<T>(*this); }
  };

  template <class T>
  PLIANT_INLINE T psi(const Tensor3<T>& H) const {
    const Tensor3<T> E = green_lagrange(H);
    const T change = volume_change(H);
    const auto valid = change > -1.0;
    const T j = select(valid, change, T(0.0)), log_J = log1p(j), I2 = second_invariant(E);
    const T t = (0.5 * (j * j) - 2.0 * I2) - 4.0 * det(E) + x_minus_log1p(j);
    const T value = 2.0 * c1 * t + 4.0 * c2 * (t + I2) + 0.5 * lambda * (log_J * log_J);
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
    const T j = select(valid, change, T(0.0));
    const Tensor3<T> E = green_lagrange(H), F = add_to_diagonal(H, 1.0);
    const Tensor3<T> G = select(valid, T(1.0 / (1.0 + j)), T(nan)) * cofactor(F);
    const T tr = trace(E);
    const Tensor3<T> M = (4.0 * (c1 + c2) + 8.0 * c2 * tr) * E - (8.0 * c2) * matmul(E, E);
    return {c1, c2, lambda, E, F, G, matmul(G, add_to_diagonal(M, T(4.0 * c2 * tr + lambda * log1p(j))))};
  }
};

static_assert(ElasticLawTemplate<MooneyRivlinCoupled> && IsotropicLaw<MooneyRivlinCoupled<double>>);

}  // namespace pliant
