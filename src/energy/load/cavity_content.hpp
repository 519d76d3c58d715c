/// Contents of cavities: the pressure as a function of the swept volume; pure functions.
///
/// The volume is V = V0 - S, with S >= 0 where the walls have moved inwards. The gauge pressure p(S, t) is relative to
/// the surroundings; the potential of the content is Phi(S) = int p dS, so that the walls feel the force -p dS/dq.
#pragma once

#include "base/expression.hpp"
#include "base/time_integral.hpp"

#include <cmath>
#include <limits>
#include <variant>

namespace pliant {

/// Time and load factor f of a simulation: the fraction of its loads that is applied. The amount pumped in grows with
/// f; the stiffness of the fluid does not.
struct LoadState {
  double time = 0.0;         ///< t [s]
  double load_factor = 1.0;  ///< f
};

/// A pressure that is controlled.
struct GivenPressure {
  Expression value;  ///< p(t) [Pa]

  double pressure(double /*S*/, const LoadState& at) const { return at.load_factor * value(0.0, 0.0, 0.0, at.time); }
  /// dp/dS [Pa/m^3].
  double stiffness(double /*S*/, const LoadState& /*at*/) const { return 0.0; }
  /// int p dS from S to S + dS [J].
  double work(double S, double dS, const LoadState& at) const { return pressure(S, at) * dS; }
  bool depends_on_time() const { return value.depends_on_time(); }
};

/// A gas that fills the cavity: (p + p_a) V^n = m(t) (p_0 + p_a) V0^n.
struct Gas {
  double volume = 0.0;    ///< V0 [m^3]
  double initial = 0.0;   ///< p_0, gauge [Pa]
  double ambient = 0.0;   ///< p_a, absolute [Pa]
  double exponent = 1.0;  ///< n: 1 isothermal, 1.4 adiabatic (air)
  Expression amount;      ///< m(t), relative to the gas at the start

  /// NaN where no volume is left.
  double absolute(double S, const LoadState& at) const {
    const double ratio = 1.0 - S / volume;
    if (!(ratio > 0.0)) return std::numeric_limits<double>::quiet_NaN();
    const double m = 1.0 + at.load_factor * (amount(0.0, 0.0, 0.0, at.time) - 1.0);
    return m * (at.load_factor * initial + ambient) * std::pow(ratio, -exponent);
  }
  double pressure(double S, const LoadState& at) const { return absolute(S, at) - ambient; }
  double stiffness(double S, const LoadState& at) const { return exponent * absolute(S, at) / (volume - S); }
  /// +inf where no volume is left.
  double work(double S, double dS, const LoadState& at) const {
    const double V = volume - S, x = -dS / V;
    if (!(V > 0.0 && x > -1.0)) return std::numeric_limits<double>::infinity();
    // -int p_abs dV = -p_abs V ((1 + x)^(1 - n) - 1) / (1 - n)
    const double rest = 1.0 - exponent, logarithm = std::log1p(x);
    const double change = rest == 0.0 ? logarithm : std::expm1(rest * logarithm) / rest;
    return -absolute(S, at) * V * change - ambient * dS;
  }
  bool depends_on_time() const { return amount.depends_on_time(); }
};

/// A liquid that fills the cavity, and the amount pumped in: p = p_0 + K (S + A(t)) / V0.
struct Liquid {
  double volume = 0.0;        ///< V0 [m^3]
  double initial = 0.0;       ///< p_0 [Pa]
  double bulk_modulus = 0.0;  ///< K [Pa]
  Expression added;           ///< part of A(t), volume at the pressure of the surroundings [m^3]
  TimeIntegral flow = {};     ///< the rest of A(t) [m^3]

  double pressure(double S, const LoadState& at) const {
    const double A = at.load_factor * (added(0.0, 0.0, 0.0, at.time) + flow(at.time));
    return at.load_factor * initial + bulk_modulus * (S + A) / volume;
  }
  double stiffness(double /*S*/, const LoadState& /*at*/) const { return bulk_modulus / volume; }
  double work(double S, double dS, const LoadState& at) const { return pressure(S + 0.5 * dS, at) * dS; }
  bool depends_on_time() const { return added.depends_on_time() || !flow.is_zero(); }
};

using CavityContent = std::variant<GivenPressure, Gas, Liquid>;

}  // namespace pliant
