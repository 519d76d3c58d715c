/// Scalar equations between two rigid bodies, of which joints consist, and their derivatives in time and configuration.
#pragma once

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
  Vector3<T> point(const Vector3<double>& X) const { return displacement(X) + lift(X); }
  Vector3<T> displacement(const Vector3<double>& X) const { return translation + turned(X - centre); }
  /// The material direction a.
  Vector3<T> direction(const Vector3<double>& a) const { return lift(a) + turned(a); }
  /// What the gradient adds to the material direction a.
  Vector3<T> turned(const Vector3<double>& a) const {
    const auto row = [&](int i) { return a[0] * gradient(i, 0) + a[1] * gradient(i, 1) + a[2] * gradient(i, 2); };
    return {row(0), row(1), row(2)};
  }

 private:
  static Vector3<T> lift(const Vector3<double>& a) { return {T(a[0]), T(a[1]), T(a[2])}; }
};

/// The motion of a body and its derivatives by the body's unknowns, actual and virtual ones.
struct PartMotion {
  BodyMotion<double> value;
  std::vector<BodyMotion<double>> columns, test_columns;
};

/// The derivative of a scalar by the motion of a body: ds = translation . d(translation) + gradient : d(gradient).
struct MotionForce {
  Vector3<double> translation{};
  Tensor3<double> gradient{};

  /// ds along a motion.
  double along(const BodyMotion<double>& d) const {
    double sum = dot(translation, d.translation);
    for (std::size_t i = 0; i < 9; ++i) sum += gradient.a[i] * d.gradient.a[i];
    return sum;
  }
  /// Adds s times another one.
  void add(double s, const MotionForce& other) {
    translation = translation + s * other.translation;
    for (std::size_t i = 0; i < 9; ++i) gradient.a[i] += s * other.gradient.a[i];
  }
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
/// together. Lengths in metres, except that Perpendicularity and Turn are numbers. g is a polynomial of the second
/// degree in the numbers of both motions: its gradient is affine in them, which gives all derivatives.
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

  using Motions = std::array<const BodyMotion<double>*, 2>;
  using Forces = std::array<MotionForce, 2>;
  /// dg by the motions of both bodies.
  Forces gradient(const Motions& motions, const TimeSeries<double>& given) const;
  /// The change of the gradient when the motions move by these.
  Forces change_of_gradient(const Motions& moves, const TimeSeries<double>& given) const;
  /// The gradient of d2g/dt2 where values, rates and accelerations of the motions move by the same. `once`, `twice`:
  /// value + rate and value + 2 rate + acceleration of each motion. For the second derivative of a product, (x y)'' =
  /// x'' y + 2 x' y' + x y'', this is the gradient of g at `twice`, except that what is given has rates of its own.
  Forces gradient_of_acceleration(const Motions& values, const Motions& once, const Motions& twice,
                                  const TimeSeries<double>& given) const;
};

}  // namespace pliant
