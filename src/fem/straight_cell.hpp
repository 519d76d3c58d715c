/// The linear shape functions of a straight tetrahedron.
#pragma once

#include "base/vector3.hpp"

#include <array>

namespace pliant {

/// The gradients of N_a, which is 1 at the corner x_a and 0 at the others [1/m].
inline std::array<Vector3<double>, 4> linear_gradients(const std::array<Vector3<double>, 4>& x) {
  const Vector3<double> a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const double inverse = 1.0 / dot(a, cross(b, c));
  std::array<Vector3<double>, 4> result{{{}, inverse * cross(b, c), inverse * cross(c, a), inverse * cross(a, b)}};
  result[0] = -1.0 * (result[1] + result[2] + result[3]);
  return result;
}

}  // namespace pliant
