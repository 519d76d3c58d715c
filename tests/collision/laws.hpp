/// Laws of contact, written for the tests.
#pragma once

#include <cmath>

namespace pliant::testing_collision {

struct Response {
  double energy = 0.0, pressure = 0.0, stiffness = 0.0;
};

/// U = -(1 - d)^2 log d, with the width and the stiffness 1.
inline Response barrier(double d) {
  if (d >= 1.0) return {};
  const double rest = 1.0 - d, log_d = std::log(d);
  return {-rest * rest * log_d, rest * rest / d - 2.0 * rest * log_d,
          rest * rest / (d * d) + 4.0 * rest / d - 2.0 * log_d};
}

/// A spring of stiffness 1 that begins at the distance 1.
inline Response penalty(double d) {
  if (d >= 1.0) return {};
  return {0.5 * (1.0 - d) * (1.0 - d), 1.0 - d, 1.0};
}

}  // namespace pliant::testing_collision
