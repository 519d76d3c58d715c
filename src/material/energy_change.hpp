/// The change of a law's energy between two nearby states, accurate relative to the change.
#pragma once

#include "material/law.hpp"

namespace pliant {

/// psi(H + dH) - psi(H). The difference of two values loses accuracy by cancellation: near convergence, a Newton step
/// changes a strained body's energy by far less than the rounding error of the energy. Small increments are therefore
/// integrated, int_0^1 P(H + s dH) : dH ds, by the Gauss rule with three points. It is exact if psi is a polynomial of
/// degree 6, and for |F^-1 dH| <= 2^-8 accurate to about 1e-15 of dH : A : dH for a logarithm of J too. Such increments
/// do not reach J = 0. They may reach a limit of stretch; near it psi grows so fast that the difference is accurate.
template <class T, ElasticLaw L>
PLIANT_INLINE T energy_change(const L& law, const Tensor3<T>& H, const Tensor3<T>& dH) {
  constexpr double small = 1.0 / 256;
  if constexpr (requires { requires L::has_stretch_limit; }) {
    const T before = law.psi(H), after = law.psi(H + dH);
    if (!all_of(after - before <= small * before && before - after <= small * before)) return after - before;
  }
  const Tensor3<T> F = add_to_diagonal(H, 1.0), C = cofactor(F);
  const T J = det(F);
  // |F^-1 dH| <= |cof F| |dH| / J
  if (!all_of(J > 0.0 && dot(C, C) * dot(dH, dH) <= small * small * (J * J))) return law.psi(H + dH) - law.psi(H);
  constexpr double offset = 0.38729833462074168852;  // sqrt(3/5) / 2
  const auto power = [&](double s) -> T { return dot(law.P(H + s * dH), dH); };
  return (5.0 * (power(0.5 - offset) + power(0.5 + offset)) + 8.0 * power(0.5)) / 18.0;
}

}  // namespace pliant
