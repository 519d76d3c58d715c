/// The angle or the travel of a joint as a function of the motions of its bodies.
#pragma once

#include "base/dual.hpp"
#include "energy/rigid/joint_equation.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace pliant {

/// The angle by which the second body is turned against the first about an axis, up to whole turns; e, f and the axis
/// are orthonormal.
struct JointAngle {
  Vector3<double> e{}, f{};
};
/// How far the material point of the second body has travelled along a direction of the first [m].
struct JointTravel {
  Vector3<double> point{}, direction{};
};
using JointCoordinate = std::variant<JointAngle, JointTravel>;

/// The value of an angle up to whole turns that is nearest to another [rad].
inline double nearest_turn(double angle, double near) {
  return near + std::remainder(angle - near, 2.0 * std::numbers::pi);
}

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

/// A material direction or point of one of the two bodies.
struct JointVector {
  std::size_t body = 0;
  bool is_point = false;
  Vector3<double> at_start{};

  template <class T>
  Vector3<T> operator()(const BodyMotion<T>& motion) const {
    return is_point ? motion.point(at_start) : motion.direction(at_start);
  }
};

/// The vectors of which a coordinate is a function; they are affine in the motions of the bodies.
using JointVectors = std::array<JointVector, 3>;
inline JointVectors vectors_of(const JointAngle& joint) {
  return {{{0, false, joint.e}, {0, false, joint.f}, {1, false, joint.e}}};
}
inline JointVectors vectors_of(const JointTravel& joint) {
  return {{{0, false, joint.direction}, {0, true, joint.point}, {1, true, joint.point}}};
}

/// The coordinate at the present vectors x.
template <class T>
T coordinate_at(const JointAngle&, const std::array<Vector3<T>, 3>& x) {
  return angle_of(dot(x[2], x[1]), dot(x[2], x[0]));
}
template <class T>
T coordinate_at(const JointTravel&, const std::array<Vector3<T>, 3>& x) {
  return dot(x[0], x[2] - x[1]);
}

template <class Joint, class T>
T coordinate_of(const Joint& joint, const BodyMotion<T>& a, const BodyMotion<T>& b) {
  std::array<Vector3<T>, 3> x;
  const JointVectors vectors = vectors_of(joint);
  for (std::size_t d = 0; d < 3; ++d) x[d] = vectors[d](vectors[d].body == 0 ? a : b);
  return coordinate_at(joint, x);
}

}  // namespace pliant
