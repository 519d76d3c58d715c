#include "energy/volume/step_bound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pliant {

double first_inversion(const Tensor3<double>& F, const Tensor3<double>& dF) {
  // det(F + alpha dF) = c0 + c1 alpha + c2 alpha^2 + c3 alpha^3
  const double c0 = det(F), c1 = dot(cofactor(F), dF), c2 = dot(F, cofactor(dF)), c3 = det(dF);
  const auto value = [&](double alpha) { return c0 + alpha * (c1 + alpha * (c2 + alpha * c3)); };
  // Between 0, the extrema and 1 the cubic is monotone: the first piece that ends at or below zero holds the root.
  std::array<double, 3> ends{1.0, 1.0, 1.0};
  const double a = 3.0 * c3, b = 2.0 * c2, discriminant = b * b - 4.0 * a * c1;
  if (discriminant >= 0.0) {
    const double s = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    if (a != 0.0) ends[0] = s / a;
    if (s != 0.0) ends[1] = c1 / s;
    for (double& end : ends) end = end > 0.0 && end < 1.0 ? end : 1.0;
    std::sort(ends.begin(), ends.end());
  }
  double below = 0.0;
  for (const double end : ends) {
    if (value(end) <= 0.0) {
      double above = end;
      for (int i = 0; i < 200 && above - below > 1e-12 * above; ++i) {
        const double middle = 0.5 * (below + above);
        (value(middle) > 0.0 ? below : above) = middle;
      }
      return above;
    }
    below = end;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace pliant
