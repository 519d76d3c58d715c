/// Scalar equations between two rigid bodies, of which joints consist, and their derivatives in time and configuration.
#pragma once

#include "base/dual.hpp"
#include "base/expression.hpp"
#include "base/vector3.hpp"
#include "energy/rigid/time_series.hpp"

#include <array>
#include <optional>
#include <variant>
#include <vector>

namespace pliant {

/// An affine motion of a body: u(X) = translation + gradient (X - centre) [m]; rigid at the end of a step.
template <class T>
struct BodyMotion {
  Vector3<double> centre{};
  Vector3<T> translation{};
  Tensor3<T> gradient{};

  /// The place of the material point X.
  Vector3<T> point(const Vector3<double>& X) const {
    return translation + matvec(gradient, lift(X - centre)) + lift(X);
  }
  /// The material direction a.
  Vector3<T> direction(const Vector3<double>& a) const { return lift(a) + matvec(gradient, lift(a)); }

 private:
  static Vector3<T> lift(const Vector3<double>& a) { return {T(a[0]), T(a[1]), T(a[2])}; }
};

/// The material point X of both bodies is at one place, seen along a fixed direction: n . (x_b(X) - x_a(X)) = 0.
struct Coincidence {
  Vector3<double> point{}, normal{};
};
/// The material direction b of the second body stays perpendicular to a of the first: (F_a a) . (F_b b) = 0.
struct Perpendicularity {
  Vector3<double> a{}, b{};
};
/// The material point X of the second body keeps a distance, or one that is given, from the plane through X of the
/// first with the material normal n: (F_a n) . (x_b(X) - x_a(X)) = s(t).
struct Travel {
  Vector3<double> point{}, normal{};
  std::optional<Expression> given;  ///< s [m]
};
/// The second body is turned against the first by a given angle about an axis: with e, f and the axis orthonormal,
/// (F_b e) . F_a (cos(s) f - sin(s) e) = 0.
struct Turn {
  Vector3<double> e{}, f{};
  Expression given;  ///< s [rad]
};
/// The material points A of the first body and B of the second keep their distance L of the start, or one that differs
/// from it by a given s: (|x_b(B) - x_a(A)|^2 - (L + s(t))^2) / (2 L) = 0.
struct Distance {
  Vector3<double> a{}, b{};
  double at_start = 0.0;            ///< L [m]
  std::optional<Expression> given;  ///< s [m]
};

/// A smooth scalar equation g(a, b, t) = 0 of the motions of two bodies; the first member stays 0 if both move rigidly
/// together. Lengths in metres, except that Perpendicularity and Turn are numbers.
struct JointEquation {
  static constexpr int ground = -1;  ///< the number of what does not move

  std::variant<Coincidence, Perpendicularity, Travel, Turn, Distance> kind;
  std::array<int, 2> bodies{ground, ground};
  std::size_t joint = 0;  ///< of which it is a part

  /// The formula of t that moves it; nullptr: none.
  const Expression* given() const;
  /// g, with the values of the formula as the number type T has them: as they are, or as series in time.
  template <class T>
  T operator()(const BodyMotion<T>& a, const BodyMotion<T>& b, const TimeSeries<double>& given) const;
};

}  // namespace pliant
