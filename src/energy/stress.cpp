#include "energy/stress.hpp"

#include <cmath>

namespace pliant {

double von_mises(const std::array<double, 6>& cauchy) {
  const auto& [xx, yy, zz, xy, yz, xz] = cauchy;
  const double a = xx - yy, b = yy - zz, c = zz - xx;
  return std::sqrt(0.5 * (a * a + b * b + c * c) + 3.0 * (xy * xy + yz * yz + xz * xz));
}

}  // namespace pliant
