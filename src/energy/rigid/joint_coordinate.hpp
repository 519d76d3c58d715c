/// The angle or the travel of a joint as a function of the motions of its bodies.
#pragma once

#include "base/dual.hpp"
#include "energy/rigid/joint_equation.hpp"

#include <cmath>

namespace pliant {

/// The angle by which the second body is turned against the first about an axis, in (-pi, pi]; e, f and the axis are
/// orthonormal.
struct JointAngle {
  Vector3<double> e{}, f{};
};
/// How far the material point of the second body has travelled along a direction of the first [m].
struct JointTravel {
  Vector3<double> point{}, direction{};
};
using JointCoordinate = std::variant<JointAngle, JointTravel>;

inline double inverse_of(double x) {
  return 1.0 / x;
}
template <class T>
Dual<T> inverse_of(const Dual<T>& x) {
  const T inverse = inverse_of(x.value);
  return {inverse, -(x.slope * inverse * inverse)};
}

inline double angle_of(double y, double x) {
  return std::atan2(y, x);
}
/// atan2: d(angle) = (x dy - y dx) / (x^2 + y^2).
template <class T>
Dual<T> angle_of(const Dual<T>& y, const Dual<T>& x) {
  return {angle_of(y.value, x.value),
          (x.value * y.slope - y.value * x.slope) * inverse_of(x.value * x.value + y.value * y.value)};
}

template <class T>
T coordinate_of(const JointAngle& joint, const BodyMotion<T>& a, const BodyMotion<T>& b) {
  const auto e = b.direction(joint.e);
  return angle_of(dot(e, a.direction(joint.f)), dot(e, a.direction(joint.e)));
}

template <class T>
T coordinate_of(const JointTravel& joint, const BodyMotion<T>& a, const BodyMotion<T>& b) {
  return dot(a.direction(joint.direction), b.point(joint.point) - a.point(joint.point));
}

}  // namespace pliant
