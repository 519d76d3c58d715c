#include "collision/ccd.hpp"

#include "collision/closest_points.hpp"
#include "collision/distance.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace pliant {
namespace {

using FourPoints = std::array<Vector3<double>, 4>;

constexpr int most_rounds = 50;
/// Rounding of the sums below relative to the largest coordinate: a product of three terms, a difference, a product
/// with t.
constexpr double rounding = 16.0 * std::numeric_limits<double>::epsilon();

struct Motion {
  FourPoints x, dx;  ///< relative to the first point and to its displacement, which leaves distances as they are
  double size, way;  ///< largest |coordinate| of both

  FourPoints at(double t) const {
    FourPoints moved;
    for (int i = 0; i < 4; ++i) moved[i] = x[i] + t * dx[i];
    return moved;
  }
};

double largest(const FourPoints& x) {
  double most = 0.0;
  for (const auto& p : x) most = std::max({most, std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
  return most;
}

Motion relative_motion(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx) {
  Motion motion{};
  for (int i = 1; i < 4; ++i) {
    motion.x[i] = x[i] - x[0];
    motion.dx[i] = dx[i] - dx[0];
  }
  motion.size = largest(motion.x);
  motion.way = largest(motion.dx);
  return motion;
}

/// The time until which min n.(a_i - b_j) >= `kept` is certain, the first `num_a` points being a's; `from` if it is not
/// certain there.
double certified_until(const Motion& motion, int num_a, const Vector3<double>& n, double kept, double from) {
  std::array<double, 4> height, speed;
  for (int i = 0; i < 4; ++i) {
    height[i] = dot(n, motion.x[i]);
    speed[i] = dot(n, motion.dx[i]);
  }
  double until = 1.0;
  const double error = rounding * (motion.size + motion.way);
  for (int i = 0; i < num_a; ++i) {
    for (int j = num_a; j < 4; ++j) {
      const double room = height[i] - height[j] - error - kept, closing = speed[j] - speed[i];
      // Linear in time: it holds in between where it holds at both ends.
      if (room < from * closing) return from;
      if (closing > 0.0) until = std::min(until, room / closing);
    }
  }
  return std::max(until * (1.0 - rounding), from);
}

/// `stencil(x)` of the closest points.
template <class StencilAt>
double max_step(const Motion& motion, int num_a, const Clearance& clearance, const StencilAt& stencil) {
  double reached = 0.0, kept = 0.0, enough = 0.0;
  for (int round = 0; round < most_rounds; ++round) {
    const FourPoints x = motion.at(reached);
    const Separation<4> closest = separation<4>(stencil(x), x);
    const double distance = closest.distance;
    if (!(distance > 0.0)) break;
    if (round == 0) {
      const double gap = distance - clearance.least - 2.0 * rounding * (motion.size + motion.way);
      if (!(gap > 0.0)) return 0.0;
      kept = clearance.least + clearance.kept * gap;
      enough = clearance.least + 2.0 * clearance.kept * gap;
    } else if (distance <= enough) {
      break;
    }
    const double next = certified_until(motion, num_a, closest.normal, kept, reached);
    if (next >= 1.0 - 2.0 * rounding) return 1.0;
    if (!(next > reached)) break;
    reached = next;
  }
  return reached;
}

}  // namespace

double max_step_point_triangle(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                               const Clearance& clearance) {
  return max_step(relative_motion(x, dx), 1, clearance,
                  [](const FourPoints& at) { return stencil_of(closest_point_triangle(at)); });
}

double max_step_edge_edge(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                          const Clearance& clearance) {
  return max_step(relative_motion(x, dx), 2, clearance,
                  [](const FourPoints& at) { return stencil_of(closest_edge_edge(at)); });
}

}  // namespace pliant
