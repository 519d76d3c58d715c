/// Softening of rubber by the largest strain it has seen (Mullins effect), a pure function of energies.
///
/// W is the energy of distortion that the elastic law stores per reference volume, Wm the largest W of the past, and
///
///     eta(W; Wm) = 1 - erf(x)/r,   x = (Wm - W)/s,   s = m + beta Wm      where W < Wm, else 1
///
/// multiplies the law's stress. The work that is done from Wm to W is then that of the law and the integral of eta - 1,
///
///     h(W; Wm) = int_W^Wm 1 - eta dw = s/r E(x),   E(x) = int_0^x erf = x erf(x) - (1 - exp(-x^2))/sqrt(pi)
///
/// Unloading to W = 0 returns h(0; Wm) less than what loading took: what has been lost so far is a function of Wm
/// alone. Sources: Ogden & Roxburgh, Proc. R. Soc. A 455 (1999) 2861-2877 (beta = 0); Bose, Hurtado & Zapas, Modelling
/// of stress softening in filled elastomers, in: Constitutive Models for Rubber III (2003) (beta).
#pragma once

#include "base/limits.hpp"
#include "base/simd.hpp"
#include "base/vector_math.hpp"

#include <cmath>
#include <numbers>

namespace pliant {

/// r > 1, m >= 0, beta >= 0, m + beta > 0; not numbers until they are given.
struct Mullins {
  double r = nan;     ///< 1 - 1/r is the least eta [1]
  double m = nan;     ///< [J/m^3]
  double beta = nan;  ///< [1]

  /// eta - 1.
  Pack eta_change(const Pack& W, const Pack& Wm) const { return (-1.0 / r) * erf(distance(W, Wm)); }

  /// d eta / dW, >= 0 [m^3/J]; on the primary curve, but for rounding, that of further loading.
  Pack eta_slope(const Pack& W, const Pack& Wm) const {
    const Pack x = distance(W, Wm);
    const Pack rounding = on_curve * (Wm + width(Wm));
    return select(Wm - W > rounding, Pack(2.0 / (r * root_of_pi) * exp(Pack(-x * x)) / width(Wm)), Pack(0.0));
  }

  /// h(W; Wm) [J/m^3].
  Pack withheld(const Pack& W, const Pack& Wm) const { return width(Wm) / r * integral(distance(W, Wm)); }

  /// h(W + dW; Wm) - h(W; Wm), accurate relative to dW.
  Pack withheld_change(const Pack& W, const Pack& dW, const Pack& Wm) const {
    constexpr double small = 1.0 / 64;
    const Pack s = width(Wm), from = distance(W, Wm), to = distance(W + dW, Wm);
    const Pack dx = select(from > 0.0 && to > 0.0, Pack(-dW / s), to - from);
    const auto is_large = !(dx * dx <= small * small);
    // The Gauss rule with three points: its error is some 1e-16 of dx.
    constexpr double offset = 0.38729833462074168852;  // sqrt(3/5) / 2
    const auto mean = [&](double part) { return erf(Pack(from + part * dx)); };
    Pack change = dx * (5.0 * (mean(0.5 - offset) + mean(0.5 + offset)) + 8.0 * mean(0.5)) / 18.0;
    if (any_of(is_large)) change = select(is_large, integral(to) - integral(from), change);
    return s / r * change;
  }

  /// What has been lost where the largest energy so far is Wm [J/m^3].
  Pack dissipated(const Pack& Wm) const { return withheld(0.0, Wm); }

 private:
  static constexpr double root_of_pi = 1.0 / std::numbers::inv_sqrtpi;

  /// s, or 1 where nothing has happened and m = 0.
  Pack width(const Pack& Wm) const {
    const Pack s = m + beta * Wm;
    return select(s > 0.0, s, Pack(1.0));
  }
  static constexpr double on_curve = 1e-10;
  /// x, 0 on the primary curve.
  Pack distance(const Pack& W, const Pack& Wm) const {
    const Pack x = (Wm - W) / width(Wm);
    return select(x > 0.0, x, Pack(0.0));
  }
  static Pack erf(const Pack& x) {
    if (!any_of(x > 0.0)) return 0.0;
    return Pack([&](auto lane) { return std::erf(static_cast<double>(x[lane])); });
  }
  /// E.
  static Pack integral(const Pack& x) { return x * erf(x) + std::numbers::inv_sqrtpi * expm1(Pack(-x * x)); }
};

}  // namespace pliant
