#include "collision/ccd.hpp"

#include "collision/closest_points.hpp"
#include "collision/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

/// A unit normal, and its rate: orthogonal to it, and not larger than `fastest`.
struct TurningNormal {
  Vector3<double> n, rate;
};

/// Faster ones gain nothing, and lose digits.
constexpr double fastest = 100.0;

/// The least t > 0 at which a + b t + c t^2 = 0, with a > 0; infinity if there is none.
double first_root(double a, double b, double c) {
  const double square = b * b - 4.0 * a * c;
  const double divisor = square < 0.0 ? 0.0 : std::sqrt(square) - b;
  return divisor > 0.0 ? 2.0 * a / divisor : std::numeric_limits<double>::infinity();
}

/// The time until which min N.(a_i - b_j) >= `kept` |N| is certain, where N = n + (t - from) rate and the first `num_a`
/// points, `x` at the time `from`, are a's; `from` if it is not certain there.
double certified_until(const Motion& motion, const FourPoints& x, int num_a, const TurningNormal& normal, double kept,
                       double from) {
  const auto& [n, rate] = normal;
  std::array<double, 4> height, speed, bend;
  for (int i = 0; i < 4; ++i) {
    height[i] = dot(n, x[i]);
    speed[i] = dot(n, motion.dx[i]) + dot(rate, x[i]);
    bend[i] = dot(rate, motion.dx[i]);
  }
  // |N| <= 1 + (t - from)^2 |rate|^2 / 2
  const double turning = norm(rate), error = rounding * (motion.size + motion.way),
               longer = 0.5 * kept * turning * turning;
  double until = 1.0;
  for (int i = 0; i < num_a; ++i) {
    for (int j = num_a; j < 4; ++j) {
      const double room = height[i] - height[j] - error - kept;
      if (!(room > 0.0)) return from;
      const double parting = speed[i] - speed[j] - error * turning, bending = bend[i] - bend[j] - longer;
      until = std::min(until, from + first_root(room, parting, bending));
    }
  }
  return std::max(until * (1.0 - rounding), from);
}

/// How the normal turns with lines and planes that are closest.
Vector3<double> rate_with_features(const Separation<4>& at, const FourPoints& dx) {
  Vector3<double> rate{};
  for (int k = 0; k < at.num_slopes; ++k) {
    rate = rate - dot(at.normal, combine<4>(at.slopes[k], dx)) * at.tangents[k];
  }
  rate = rate - dot(rate, at.normal) * at.normal;
  const double size = norm(rate);
  return size <= fastest ? rate : (size < std::numeric_limits<double>::infinity() ? fastest / size : 0.0) * rate;
}

/// The least t in (0, 1] up to which c[0] + c[1] t + c[2] t^2 + c[3] t^3 >= 0, with c[0] > 0: short of the first root.
double first_root(const std::array<double, 4>& c) {
  const auto value = [&](double t) { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); };
  std::array<double, 3> ends{1.0, 1.0, 1.0};  // of intervals in which it only falls or only rises
  const double square = c[2] * c[2] - 3.0 * c[1] * c[3];
  if (square > 0.0) {
    const double q = -(c[2] + std::copysign(std::sqrt(square), c[2]));
    ends = {std::clamp(q / (3.0 * c[3]), 0.0, 1.0), std::clamp(c[1] / q, 0.0, 1.0), 1.0};
    if (!(ends[0] <= ends[1])) std::swap(ends[0], ends[1]);  // NaN first
  }
  double low = 0.0;
  for (double high : ends) {
    if (!(high > low)) continue;
    if (value(high) >= 0.0) {
      low = high;
      continue;
    }
    for (int halving = 0; halving < 30; ++halving) {
      const double middle = 0.5 * (low + high);
      (value(middle) >= 0.0 ? low : high) = middle;
    }
    return low;
  }
  return 1.0;
}

/// The time until which the distance of two lines, or of a point and a plane, is certain to be at least `kept`. With
/// vectors u, v along the features and r between them it is N.r / |N|, N = u x v, of which the first factor is a
/// polynomial of third degree, and the second not more than one of second.
double certified_until_lines_meet(const Motion& motion, const FourPoints& x, int num_a, const Separation<4>& at,
                                  double kept, double from) {
  const auto side = [&](const FourPoints& y, int k) {
    if (num_a == 1) return y[k == 0 ? 2 : 3] - y[1];
    return k == 0 ? y[1] - y[0] : y[3] - y[2];
  };
  const double rest = 1.0 - from;
  const Vector3<double> u0 = side(x, 0), u1 = rest * side(motion.dx, 0), v0 = side(x, 1),
                        v1 = rest * side(motion.dx, 1);
  Vector3<double> n0 = cross(u0, v0), n1 = cross(u1, v0) + cross(u0, v1), n2 = cross(u1, v1);
  const Vector3<double> r0 = at.r, r1 = rest * combine<4>(at.weights, motion.dx);
  if (dot(n0, r0) < 0.0) {
    n0 = -1.0 * n0;
    n1 = -1.0 * n1;
    n2 = -1.0 * n2;
  }
  // |N| <= (1 - t)^2 |n0| + 2 t (1 - t) |n0 + n1/2| + t^2 |n0 + n1 + n2|
  const double a = norm(n0), b = norm(n0 + 0.5 * n1), c = norm(n0 + n1 + n2);
  const double size = motion.size + motion.way;
  const double error = rounding * size * (std::max({a, b, c}) + size * (norm(r0) + norm(r1)));
  const std::array<double, 4> polynomial{dot(n0, r0) - error - kept * a,
                                         dot(n1, r0) + dot(n0, r1) - 2.0 * kept * (b - a),
                                         dot(n2, r0) + dot(n1, r1) - kept * (a - 2.0 * b + c), dot(n2, r1)};
  if (!(polynomial[0] > 0.0)) return from;
  return std::max(from + (1.0 - rounding) * first_root(polynomial) * rest, from);
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
    double next = certified_until(motion, x, num_a, {closest.normal, {}}, kept, reached);
    if (next < 1.0 - 2.0 * rounding && closest.num_slopes > 0) {
      const Vector3<double> rate = rate_with_features(closest, motion.dx);
      next = std::max(next, certified_until(motion, x, num_a, {closest.normal, rate}, kept, reached));
    }
    if (next < 1.0 - 2.0 * rounding && closest.num_slopes == 2) {
      next = std::max(next, certified_until_lines_meet(motion, x, num_a, closest, kept, reached));
    }
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

double max_step_into_triangle(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                              double least, double depth) {
  constexpr double kept = 0.01;
  const double at_surface = max_step_point_triangle(x, dx, {least, kept});
  if (!(at_surface < 1.0)) return 1.0;
  FourPoints y;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = x[i] + at_surface * dx[i];
  const Separation<4> closest = separation<4>(stencil_of(closest_point_triangle(y)), y);
  const Vector3<double> normal = cross(y[2] - y[1], y[3] - y[1]);
  const double size = norm(normal);
  if (!(size > 0.0) || dot(normal, closest.r) < 0.0) return 1.0;
  const double approach = -dot(normal, combine<4>(closest.weights, dx)) / size;
  return approach > 0.0 ? std::min(at_surface + depth / approach, 1.0) : 1.0;
}

double max_step_edge_edge(std::span<const Vector3<double>, 4> x, std::span<const Vector3<double>, 4> dx,
                          const Clearance& clearance) {
  return max_step(relative_motion(x, dx), 2, clearance,
                  [](const FourPoints& at) { return stencil_of(closest_edge_edge(at)); });
}

}  // namespace pliant
