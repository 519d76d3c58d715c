#include "collision/ccd.hpp"
#include "collision/closest_points.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>

namespace pliant::test_ccd {
namespace {

using namespace testing_collision;
using Long = long double;
using LongVector = Vector3<Long>;
using LongPoints = std::array<LongVector, 4>;

/// Distances in higher precision, by other formulas than those of the library.
Long point_segment(const LongVector& p, const LongVector& a, const LongVector& b) {
  const LongVector e = b - a;
  const Long length2 = dot(e, e), s = length2 > 0 ? std::clamp<Long>(dot(p - a, e) / length2, 0, 1) : 0;
  const LongVector off = p - a - s * e;
  return dot(off, off);
}
Long point_triangle(const LongPoints& x) {
  Long d2 =
      std::min({point_segment(x[0], x[1], x[2]), point_segment(x[0], x[2], x[3]), point_segment(x[0], x[3], x[1])});
  const LongVector u = x[2] - x[1], v = x[3] - x[1], r = x[0] - x[1];
  const Long uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  if (det > 1e-24L * uu * vv) {
    const Long s = (vv * dot(u, r) - uv * dot(v, r)) / det, t = (uu * dot(v, r) - uv * dot(u, r)) / det;
    const LongVector off = r - s * u - t * v;
    if (s >= 0 && t >= 0 && s + t <= 1) d2 = std::min(d2, dot(off, off));
  }
  return std::sqrt(d2);
}
Long edge_edge(const LongPoints& x) {
  Long d2 = std::min({point_segment(x[0], x[2], x[3]), point_segment(x[1], x[2], x[3]), point_segment(x[2], x[0], x[1]),
                      point_segment(x[3], x[0], x[1])});
  const LongVector u = x[1] - x[0], v = x[3] - x[2], r = x[2] - x[0];
  const Long uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  if (det > 1e-24L * uu * vv) {
    const Long s = (vv * dot(u, r) - uv * dot(v, r)) / det, t = (uv * dot(u, r) - uu * dot(v, r)) / det;
    const LongVector off = r + t * v - s * u;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) d2 = std::min(d2, dot(off, off));
  }
  return std::sqrt(d2);
}

struct Kind {
  double (*max_step)(std::span<const Vector3<double>, 4>, std::span<const Vector3<double>, 4>, const Clearance&);
  Long (*distance)(const LongPoints&);
};
const std::array<Kind, 2> kinds{{{max_step_point_triangle, point_triangle}, {max_step_edge_edge, edge_edge}}};

struct Case {
  Points<4> x, dx;
  LongPoints at(Long t) const {
    LongPoints moved;
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 3; ++k) moved[i][k] = x[i][k] + t * dx[i][k];
    }
    return moved;
  }
  /// How fast a distance can change.
  Long speed() const {
    Long most = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) most = std::max<Long>(most, norm(dx[i] - dx[j]));
    }
    return most;
  }
};

/// Whether the distance is above `bound` all the way: every interval is halved until its middle proves it. Intervals
/// shorter than `shortest` are taken for proved.
bool stays_above(const Case& motion, const Kind& kind, Long bound, Long from, Long to, Long shortest) {
  const Long middle = (from + to) / 2, d = kind.distance(motion.at(middle));
  if (d < bound) return false;
  if (d - motion.speed() * (to - from) / 2 >= bound || to - from < shortest) return true;
  return stays_above(motion, kind, bound, from, middle, shortest) &&
         stays_above(motion, kind, bound, middle, to, shortest);
}

/// Generic, parallel, coplanar, fast, grazing, far from the origin, and degenerate motions.
Case random_case(RandomPoints& random) {
  Case c{random.points<4>(), random.points<4>(2.0)};
  switch (random.integer(0, 10)) {
    case 0:  // coplanar, and staying so
      for (int i = 0; i < 4; ++i) c.x[i][2] = c.dx[i][2] = 0.0;
      break;
    case 1:  // parallel edges
      c.x[3] = c.x[2] + (c.x[1] - c.x[0]);
      break;
    case 2:  // nearly parallel
      c.x[3] = c.x[2] + (c.x[1] - c.x[0]) + random.point(std::pow(10.0, random.number(-16.0, -3.0)));
      break;
    case 3:  // fast
      for (auto& v : c.dx) v = 1e4 * v;
      break;
    case 4:  // on a grid
      for (auto& p : c.x) p = {std::round(2 * p[0]), std::round(2 * p[1]), std::round(2 * p[2])};
      for (auto& p : c.dx) p = {std::round(p[0]), std::round(p[1]), std::round(p[2])};
      break;
    case 5:  // features of no length
      c.x[3] = c.x[2];
      if (random.integer(0, 1) == 0) c.dx[3] = c.dx[2];
      break;
    case 6:  // far from the origin
      for (auto& p : c.x) p = p + Vector3<double>{1e3, -2e3, 3e3};
      break;
    case 7: {  // close, across flat features that pass one another
      const double gap = std::pow(10.0, random.number(-10.0, -1.0));
      for (int i = 0; i < 4; ++i) c.x[i][2] = i == 0 ? gap : 0.0;
      c.dx[0][2] = -2.0 * gap * random.number(0.0, 1.0);
      for (int i = 1; i < 4; ++i) c.dx[i][2] = 0.0;
      break;
    }
    case 8: {  // close, and turning about one another
      const double gap = std::pow(10.0, random.number(-10.0, -1.0)), angle = random.number(0.0, 0.3);
      for (int i = 0; i < 4; ++i) c.x[i][2] = i == 0 || (i == 1 && random.integer(0, 1) == 0) ? gap : 0.0;
      const Vector3<double> spin = angle * random.point();
      for (int i = 0; i < 4; ++i) c.dx[i] = cross(spin, c.x[i]) + random.point(gap) + random.point(1e-3 * angle);
      break;
    }
    case 9:  // slivers
      c.x[3] = random.number(0.0, 1.0) * (c.x[1] + c.x[2]) + random.point(std::pow(10.0, random.number(-14.0, -3.0)));
      break;
    default:
      break;
  }
  return c;
}

TEST(Ccd, NoStepEverPasses) {
  RandomPoints random(1);
  int hit = 0, free = 0, refused = 0, short_of = 0, proved = 0;
  for (int trial = 0; trial < 100000; ++trial) {
    const Case motion = random_case(random);
    const Kind& kind = kinds[trial % 2];
    const Long start = kind.distance(motion.at(0));
    const Clearance clearance{.least = trial % 3 == 0 ? 0.3 * static_cast<double>(start) : 0.0, .kept = 0.1};
    const double alpha = kind.max_step(motion.x, motion.dx, clearance);
    ASSERT_GE(alpha, 0.0);
    ASSERT_LE(alpha, 1.0);
    if (alpha == 0.0) {
      ASSERT_LT(start - clearance.least, 1e-7L) << "trial " << trial;  // in the case far from the origin
      ++refused;
      continue;
    }
    const Long kept = clearance.least + clearance.kept * (start - clearance.least);
    ASSERT_GE(kind.distance(motion.at(alpha)), kept * (1 - 1e-9L) - 1e-12L) << "trial " << trial;
    // A proof wherever the way is not thousands of gaps long.
    const Long shortest = alpha / 2000;
    proved += motion.speed() * shortest < 0.1L * kept ? 1 : 0;
    ASSERT_TRUE(stays_above(motion, kind, 0.9L * kept, 0, alpha, shortest)) << "trial " << trial;
    if (alpha == 1.0) {
      ++free;
    } else {
      ++hit;
      const Long enough = clearance.least + 2.02 * clearance.kept * (start - clearance.least);
      short_of += kind.distance(motion.at(alpha)) > enough ? 1 : 0;
    }
  }
  EXPECT_GT(hit, 10000);
  EXPECT_GT(free, 10000);
  EXPECT_GT(proved, 50000);
  EXPECT_LT(refused, 10000);  // those that touch at the start, on the grid and in the plane
  EXPECT_LT(short_of, hit / 1000);
}

/// A point that falls straight onto a triangle stops at the gap that is to be kept.
TEST(Ccd, HeadOnStopsAtWhatIsKept) {
  const Points<4> x{{{0.2, 0.2, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, dx{{{0, 0, -2}, {}, {}, {}}};
  EXPECT_NEAR(max_step_point_triangle(x, dx, {.least = 0.0, .kept = 0.1}), 0.45, 1e-12);
  EXPECT_NEAR(max_step_point_triangle(x, dx, {.least = 0.5, .kept = 0.2}), 0.2, 1e-12);
  const Points<4> leaving{{{0.3, 1, 5}, {}, {}, {}}};
  EXPECT_EQ(max_step_point_triangle(x, leaving, {.least = 0.9}), 1.0);
}

TEST(Ccd, WhatComesThroughAFaceStopsAtADepth) {
  const Points<4> triangle{{{0.2, 0.2, 1.0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};  // its normal points to the point
  const auto step = [](Points<4> x, const Vector3<double>& d, double depth) {
    const Points<4> dx{{d, {}, {}, {}}};
    return max_step_into_triangle(x, dx, 0.0, depth);
  };
  EXPECT_NEAR(step(triangle, {0, 0, -4}, 0.5), (1.0 + 0.5) / 4.0, 0.01);
  EXPECT_EQ(step(triangle, {0, 0, -1.2}, 0.5), 1.0);
  EXPECT_EQ(step(triangle, {0, 0, 4}, 0.5), 1.0);
  EXPECT_EQ(step(triangle, {5, 0, -2}, 0.5), 1.0);  // passes beside it
  Points<4> behind = triangle;
  behind[0] = {0.2, 0.2, -1.0};
  EXPECT_EQ(step(behind, {0, 0, 4}, 0.5), 1.0);
  // From the surface itself, and along it.
  Points<4> at_surface = triangle;
  at_surface[0] = {0.2, 0.2, 0.0};
  EXPECT_NEAR(step(at_surface, {0.1, 0, -2}, 0.5), 0.25, 1e-12);
  EXPECT_EQ(step(at_surface, {0.3, 0.3, 0}, 0.5), 1.0);
  // The triangle comes to the point.
  const Points<4> rising{{{}, {0, 0, 4}, {0, 0, 4}, {0, 0, 4}}};
  EXPECT_NEAR(max_step_into_triangle(triangle, rising, 0.0, 0.5), (1.0 + 0.5) / 4.0, 0.01);
}

TEST(Ccd, SlidingCloseByIsFree) {
  const Points<4> x{{{0.2, 0.2, 1e-9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, dx{{{0.7, 0.3, 0}, {}, {}, {}}};
  EXPECT_EQ(max_step_point_triangle(x, dx, {}), 1.0);
  const Points<4> edges{{{-1, 0, 1e-9}, {1, 0, 1e-9}, {0, -1, 0}, {0, 1, 0}}},
      along{{{0.4, 0, 0}, {0.4, 0, 0}, {}, {}}};
  EXPECT_EQ(max_step_edge_edge(edges, along, {}), 1.0);
}

/// Crossed edges a billionth of their length apart turn together: a straight motion along the tangents of the rotation
/// lengthens all distances.
TEST(Ccd, TurningTogetherIsFree) {
  const Points<4> edges{{{-1, 0.1, 1e-9}, {1, -0.1, 1e-9}, {0, -1, 0}, {0.2, 1, 0}}};
  for (const Vector3<double>& spin : {Vector3<double>{0.1, 0.2, 0.3}, Vector3<double>{0.0, -0.5, 0.0}}) {
    Points<4> dx;
    for (std::size_t i = 0; i < 4; ++i) dx[i] = cross(spin, edges[i]);
    EXPECT_EQ(max_step_edge_edge(edges, dx, {}), 1.0);
  }
}

TEST(Ccd, CommonMotionIsFree) {
  RandomPoints random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto x = random.points<4>();
    const Points<4> dx{{{1e3, -1e3, 5}, {1e3, -1e3, 5}, {1e3, -1e3, 5}, {1e3, -1e3, 5}}};
    EXPECT_EQ(max_step_point_triangle(x, dx, {}), 1.0);
    EXPECT_EQ(max_step_edge_edge(x, dx, {}), 1.0);
  }
}

/// Opposite edges of a thin plate that turns: parallel to their last digit, so that the normal across them is rounding.
TEST(Ccd, ParallelEdgesMayMoveTogether) {
  const Points<4> x{{{-0.020588235294117699, 0.002, 0.010000000000000002},
                     {-0.023529411764705934, 0.002, 0.0050942670810849256},
                     {-0.020588235294117702, -0.002, 0.0099999999999999967},
                     {-0.023529411764705934, -0.002, 0.0050942670810849256}}};
  Points<4> dx;
  for (std::size_t i = 0; i < 4; ++i) dx[i] = {-0.2 * x[i][1], 0.2 * x[i][0], 0.0};
  EXPECT_EQ(max_step_edge_edge(x, dx, {}), 1.0);
  EXPECT_EQ(closest_edge_edge(x).squared_distance, 0.004 * 0.004);
}

TEST(Ccd, FeaturesThatTouchAreRefused) {
  const Points<4> x{{{0.2, 0.2, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, dx{{{0, 0, 1}, {}, {}, {}}};
  EXPECT_EQ(max_step_point_triangle(x, dx, {}), 0.0);
  const Points<4> above{{{0.2, 0.2, 0.5}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  EXPECT_EQ(max_step_point_triangle(above, dx, {.least = 0.5}), 0.0);
}

}  // namespace
}  // namespace pliant::test_ccd
