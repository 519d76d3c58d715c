#include "model/contact_summary.hpp"

#include "collision/triangle_tree.hpp"

#include <cmath>

#include <fmt/format.h>

namespace pliant {

Vector3<double> without_rounding(const Vector3<double>& x, double size) {
  constexpr double rounding = 1e-9;
  Vector3<double> clean = x;
  for (double& component : clean) {
    if (std::abs(component) <= rounding * size) component = 0.0;
  }
  return clean;
}

std::string place_text(const Vector3<double>& x) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", x[0], x[1], x[2]);
}

StartGap nearer(const StartGap& a, const StartGap& b) {
  constexpr double rounding = 1e-9;
  if (!(a.gap < std::numeric_limits<double>::infinity())) return b;
  const double same = rounding * std::abs(a.gap);
  if (b.gap < a.gap - same) return b;
  return b.gap <= a.gap + same && level_of(b.place) < level_of(a.place) ? b : a;
}

}  // namespace pliant
