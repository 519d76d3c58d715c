/// Rotations as unit quaternions, and the exponential coordinates (rotation vectors) around one.
///
/// Sources: Iserles, Munthe-Kaas, Norsett & Zanna 2000, "Lie-group methods" (Acta Numerica 9), appendix B; Sola, Deray
/// & Atchuthan 2018, "A micro Lie theory for state estimation in robotics" (arXiv:1812.01537), section IV.
#pragma once

#include "base/dual.hpp"
#include "base/vector3.hpp"

#include <array>
#include <cmath>

namespace pliant {

/// Stumpff's functions of x = theta^2 >= 0 (below about (2 pi)^2), to a few units in the last place of c_k(0) = 1/k!:
///
///   c_k(x) = sum_j (-x)^j / (k + 2j)!,   c_0 = cos theta, c_1 = sin theta / theta, c_2 = (1 - cos theta) / theta^2,
///   c_3 = (theta - sin theta) / theta^3, ...;   c_k = 1/k! - x c_{k+2},   dc_k/dx = (k c_{k+2} - c_{k+1}) / 2.
///
/// The exponential consists of them; they are closed under differentiation, which gives its derivatives.
template <int k>
double stumpff(double x) {
  if constexpr (k == 0) {
    return std::cos(std::sqrt(x));
  } else if constexpr (k == 1) {
    const double theta = std::sqrt(x);
    return theta > 0.0 ? std::sin(theta) / theta : 1.0;
  } else {
    constexpr double series_limit = 10.0;  // above it the recurrence cancels less than a digit
    constexpr int num_terms = 15;          // the next one is below 1e-19 at the limit
    constexpr auto factorial = [](int n) {
      double result = 1.0;
      for (int i = 2; i <= n; ++i) result *= i;
      return result;
    };
    if (x > series_limit) return (1.0 / factorial(k - 2) - stumpff<k - 2>(x)) / x;
    double sum = 1.0;  // Horner
    for (int j = num_terms - 1; j >= 1; --j) sum = 1.0 - x * sum / ((k + 2 * j - 1) * (k + 2 * j));
    return sum / factorial(k);
  }
}

template <int k, class T>
Dual<T> stumpff(const Dual<T>& x) {
  T derivative = -0.5 * stumpff<k + 1>(x.value);
  if constexpr (k > 0) derivative = derivative + 0.5 * k * stumpff<k + 2>(x.value);
  return {stumpff<k>(x.value), derivative * x.slope};
}

/// exp(xi^) a, the vector a rotated by the rotation vector xi: a + c_1 xi x a + c_2 xi x (xi x a) (Rodrigues).
template <class T>
Vector3<T> turn(const Vector3<T>& xi, const Vector3<T>& a) {
  const T x = dot(xi, xi);
  const Vector3<T> b = cross(xi, a);
  return a + (stumpff<1>(x) * b + stumpff<2>(x) * cross(xi, b));
}

/// dexp_{-xi} a, the right Jacobian J_r(xi) a = a - c_2 xi x a + c_3 xi x (xi x a): the angular velocity in the body's
/// frame at exp(xi) when xi changes at the rate a. J_r(-xi) is the left one, that of the frame in space.
template <class T>
Vector3<T> right_jacobian(const Vector3<T>& xi, const Vector3<T>& a) {
  const T x = dot(xi, xi);
  const Vector3<T> b = cross(xi, a);
  return a + (stumpff<3>(x) * cross(xi, b) - stumpff<2>(x) * b);
}

/// A rotation: (cos(theta/2), sin(theta/2) n), n the axis. The quaternion of opposite sign is the same rotation.
using Quaternion = std::array<double, 4>;

/// exp(xi).
Quaternion exponential(const Vector3<double>& xi);
/// The rotation vector of b, of length at most pi: exp(logarithm(b)) = b. Accurate up to half a turn and there.
Vector3<double> logarithm(const Quaternion& b);
/// The rotation a after b (b is given in the frame that a leads to: R_a R_b), of unit length to rounding, so that
/// products of any number stay rotations.
Quaternion product(const Quaternion& a, const Quaternion& b);
/// The inverse rotation.
Quaternion inverse(const Quaternion& a);
/// R a.
Vector3<double> turn(const Quaternion& R, const Vector3<double>& a);
/// The orthogonal matrix of a rotation.
Tensor3<double> rotation_matrix(const Quaternion& R);

}  // namespace pliant
