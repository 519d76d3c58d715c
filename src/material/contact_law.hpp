/// Contact laws: pressure, friction and damping at an obstacle per reference area, as pure functions of the distance
/// and of the velocity.
#pragma once

#include "base/limits.hpp"
#include "base/vector3.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace pliant {

enum class NormalKind { penalty, barrier, edge_barrier };

/// The state at which a drag evaluates the pressure and the normal.
enum class FrictionUpdate {
  frozen,  ///< at the last accepted state, unless the drag then exceeds what the pressure at the solution allows: first
           ///< order in time
  iterated  ///< at the solution, by solving again until they stay the same: keeps the method's order
};

/// U(d), the pressure p = -U' and its slope U'' at a distance.
struct NormalResponse {
  double energy = 0.0;     ///< [J/m^2]; +infinity where a barrier is crossed
  double pressure = 0.0;   ///< [Pa]; NaN where a barrier is crossed
  double stiffness = 0.0;  ///< [Pa/m]
};

/// The pressure as a function of the distance d. With y = (threshold - d) / width - 1
///
///     penalty   p = k width r(y),   r = 0 (y < -1),  y (y > 1),  3/16 + y/2 + 3/8 y^2 - y^4/16 between,
///
/// a spring of stiffness k that begins at the threshold. Its kink is rounded over 2 widths, which gives U three
/// continuous derivatives, and a surface at the threshold without a force. With s = (d - threshold) / width
///
///     barrier   U = -k width^2 (1 - s)^2 log s   (0 < s < 1),   0 (s >= 1),   +infinity (s <= 0),
///
/// which has two continuous derivatives (Li et al. 2020, Incremental Potential Contact, equation 6). For edges across
/// edges, of which each has a small area but may carry all of a blow,
///
///     edge barrier   U = k width^2 (1 - s)^3 / s,
///
/// the same where it begins, and beyond it the steeper the closer: a pressure of a thousand k width leaves s = 0.03.
struct NormalLaw {
  NormalKind kind = NormalKind::penalty;
  double stiffness = 0.0;  ///< k [Pa/m]
  double width = 0.0;      ///< half of the rounding, or where a barrier begins [m]
  double threshold = 0.0;  ///< where the spring begins, or the wall stands [m]

  /// The distance beyond which there is no force [m].
  double reach() const { return kind == NormalKind::penalty ? threshold : threshold + width; }
  /// The distance below which a penalty is linear [m].
  double linear_from() const { return threshold - 2.0 * width; }

  NormalResponse operator()(double d) const {
    if (d >= reach()) return {};
    if (kind == NormalKind::penalty) return spring((threshold - d) / width - 1.0);
    const double s = (d - threshold) / width;
    return kind == NormalKind::barrier ? wall(s) : steep_wall(s);
  }

 private:
  NormalResponse spring(double y) const {
    const double kw = stiffness * width;
    if (y >= 1.0) return {kw * width * (0.1 + 0.5 * y * y), kw * y, stiffness};
    const double y2 = y * y;
    return {kw * width * (0.05 + y * (0.1875 + y * (0.25 + y * (0.125 - 0.0125 * y2)))),
            kw * (0.1875 + y * (0.5 + y * (0.375 - 0.0625 * y2))), stiffness * (0.5 + y * (0.75 - 0.25 * y2))};
  }

  NormalResponse wall(double s) const {
    if (s <= 0.0) return {infinity, nan, nan};
    const double kw = stiffness * width, rest = 1.0 - s, log_s = std::log1p(-rest);
    return {-kw * width * rest * rest * log_s, kw * (rest * rest / s - 2.0 * rest * log_s),
            stiffness * (rest * rest / (s * s) + 4.0 * rest / s - 2.0 * log_s)};
  }

  NormalResponse steep_wall(double s) const {
    if (s <= 0.0) return {infinity, nan, nan};
    const double kw = stiffness * width, ratio = (1.0 - s) / s;
    return {kw * width * ratio * (1.0 - s) * (1.0 - s), kw * ratio * (1.0 - s) * (3.0 + ratio),
            2.0 * stiffness * ratio * (3.0 + ratio * (3.0 + ratio))};
  }
};

/// A potential of the velocity relative to the obstacle: R, dR/dv and d2R/dv2.
struct DragResponse {
  double potential = 0.0;     ///< R [W/m^2]
  Vector3<double> slope{};    ///< minus the traction [Pa]
  Tensor3<double> hessian{};  ///< >= 0 [Pa s/m]
};

/// Coulomb friction and viscous friction, both in proportion to the total normal pressure p. With v_t = v - (v.n) n and
/// s = |v_t|
///
///     traction = -p (mu f(s / v_s) + eta s) v_t / s,   f(y) = (15 y - 10 y^3 + 3 y^5) / 8 (y < 1), else 1
///
/// f has two continuous derivatives and is odd, which makes the traction smooth where the velocity passes zero. Below
/// v_s a contact creeps and counts as sticking.
struct Friction {
  static constexpr std::string_view name = "friction";  ///< of its term
  double coefficient = 0.0;                             ///< mu
  double viscosity = 0.0;                               ///< eta [s/m]
  double stick_velocity = 0.0;                          ///< v_s [m/s]

  bool acts() const { return coefficient > 0.0 || viscosity > 0.0; }

  DragResponse operator()(double pressure, const Vector3<double>& n, const Vector3<double>& v) const {
    const Vector3<double> slip = v - dot(v, n) * n;
    const double square = dot(slip, slip), y2 = square / (stick_velocity * stick_velocity);
    // R_f = mu v_s g(y), f / s = along, d(f / s)/ds / s = turning
    double g = 0.0, along = 0.0, turning = 0.0;
    if (y2 < 1.0) {
      g = y2 * (0.9375 + y2 * (-0.3125 + 0.0625 * y2));
      along = (1.875 + y2 * (-1.25 + 0.375 * y2)) / stick_velocity;
      turning = (-2.5 + 1.5 * y2) / (stick_velocity * stick_velocity * stick_velocity);
    } else {
      const double s = std::sqrt(square);
      g = s / stick_velocity - 0.3125;
      along = 1.0 / s;
      turning = -1.0 / (s * square);
    }
    const double factor = pressure * (coefficient * along + viscosity), bend = pressure * coefficient * turning;
    return {pressure * (coefficient * stick_velocity * g + 0.5 * viscosity * square), factor * slip,
            make_tensor([&](int i, int j) {
              return factor * ((i == j ? 1.0 : 0.0) - n[i] * n[j]) + bend * slip[i] * slip[j];
            })};
  }

  /// Magnitude of the traction [Pa].
  double size(double pressure, const Vector3<double>& n, const Vector3<double>& v) const {
    return norm((*this)(pressure, n, v).slope);
  }
  /// Largest admissible magnitude: Coulomb's mu p plus the viscous part [Pa].
  double largest(double pressure, const Vector3<double>& n, const Vector3<double>& v) const {
    return pressure * (coefficient + viscosity * norm(v - dot(v, n) * n));
  }
};

/// Contact damping (Hunt & Crossley 1975, Coefficient of restitution interpreted as damping in vibroimpact): with c the
/// rate of approach -v.n times the damping,
///
///     pressure = p g(c),   g = c (c > -1/2),   -1 - 1/(4 c) (c < -1/2)
///
/// The total pressure p (1 + g) never pulls.
struct NormalDamping {
  static constexpr std::string_view name = "contact-damping";
  double damping = 0.0;  ///< [s/m]

  bool acts() const { return damping > 0.0; }

  /// g, the pressure that damping adds relative to p: more than -1.
  double added_part(const Vector3<double>& n, const Vector3<double>& v) const {
    const double c = -damping * dot(v, n);
    return c < -0.5 ? -1.0 - 0.25 / c : c;
  }

  DragResponse operator()(double pressure, const Vector3<double>& n, const Vector3<double>& v) const {
    const double c = -damping * dot(v, n), g = added_part(n, v);
    double integral = 0.5 * c * c, slope = 1.0;
    if (c < -0.5) {
      integral = -0.375 - c - 0.25 * std::log(-2.0 * c);
      slope = 0.25 / (c * c);
    }
    return {pressure / damping * integral, (-pressure * g) * n,
            make_tensor([&](int i, int j) { return pressure * damping * slope * n[i] * n[j]; })};
  }

  /// The tension that damping exerts [Pa].
  double size(double pressure, const Vector3<double>& n, const Vector3<double>& v) const {
    return std::max(0.0, dot((*this)(pressure, n, v).slope, n));
  }
  /// The largest tension that leaves a pressure [Pa].
  double largest(double pressure, const Vector3<double>& /*n*/, const Vector3<double>& /*v*/) const { return pressure; }
};

}  // namespace pliant
