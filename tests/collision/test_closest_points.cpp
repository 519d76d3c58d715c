#include "collision/closest_points.hpp"
#include "derivatives.hpp"

#include <map>
#include <tuple>

#include <gtest/gtest.h>

namespace pliant::test_closest_points {
namespace {

using testing_collision::Points;
using testing_collision::RandomPoints;
using Long = long double;
using LongVector = Vector3<Long>;

LongVector widened(const Vector3<double>& x) {
  return {x[0], x[1], x[2]};
}

/// The least value of a convex function of [0, 1], by golden sections.
template <class F>
Long least(const F& f) {
  constexpr Long golden = 0.61803398874989484820L;
  Long low = 0, high = 1, left = 1 - golden, right = golden, at_left = f(left), at_right = f(right);
  for (int n = 0; n < 64; ++n) {
    if (at_left < at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - golden * (high - low);
      at_left = f(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + golden * (high - low);
      at_right = f(right);
    }
  }
  return std::min({at_left, at_right, f(0), f(1)});
}

Long point_edge_reference(const Points<3>& x) {
  const LongVector p = widened(x[0]), a = widened(x[1]), b = widened(x[2]);
  return least([&](Long s) {
    const LongVector r = p - ((1 - s) * a + s * b);
    return dot(r, r);
  });
}
Long point_triangle_reference(const Points<4>& x) {
  const LongVector p = widened(x[0]), a = widened(x[1]), b = widened(x[2]), c = widened(x[3]);
  return least([&](Long s) {
    return least([&](Long t) {
      const LongVector r = p - ((1 - s) * a + s * ((1 - t) * b + t * c));
      return dot(r, r);
    });
  });
}
Long edge_edge_reference(const Points<4>& x) {
  const LongVector a = widened(x[0]), b = widened(x[1]), c = widened(x[2]), d = widened(x[3]);
  return least([&](Long s) {
    return least([&](Long t) {
      const LongVector r = (1 - s) * a + s * b - ((1 - t) * c + t * d);
      return dot(r, r);
    });
  });
}

/// Random points, and those that share coordinates, planes, lines and places.
template <int N>
Points<N> configuration(RandomPoints& random) {
  Points<N> x = random.points<N>();
  switch (random.integer(0, 6)) {
    case 0:  // in one plane
      for (auto& p : x) p[2] = 0.25;
      break;
    case 1:  // on a grid: coplanar, parallel, right-angled, coincident
      for (auto& p : x) p = {std::round(p[0]), std::round(p[1]), std::round(p[2])};
      break;
    case 2:  // the last two edges nearly parallel
      x[N - 1] = x[N - 2] + (x[1] - x[0]) + random.point(std::pow(10.0, random.number(-16.0, -2.0)));
      break;
    case 3:  // a feature of no length
      x[N - 1] = x[N - 2];
      break;
    case 4:  // slivers
      x[N - 1] = random.number(0.0, 1.0) * (x[N - 2] + x[1]) + random.point(std::pow(10.0, random.number(-16.0, -2.0)));
      break;
    case 5:  // close
      x[0] = x[N - 1] + random.point(1e-6);
      break;
    default:
      break;
  }
  return x;
}

/// Rounding of a difference of coordinates, squared where the distance is less than it.
void expect_same(double squared, Long reference, int trial) {
  const Long d = std::sqrt(static_cast<Long>(squared)), d_reference = std::sqrt(reference);
  EXPECT_NEAR(static_cast<double>(d - d_reference), 0.0, 5e-14) << "trial " << trial;
}

TEST(ClosestPoints, PointAndEdgeMatchAMinimisation) {
  RandomPoints random(1);
  std::map<EdgeFeature, int> seen;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto x = configuration<3>(random);
    const PointEdge closest = closest_point_edge(x);
    ++seen[closest.feature];
    expect_same(closest.squared_distance, point_edge_reference(x), trial);
  }
  EXPECT_EQ(seen.size(), 3U);
}

TEST(ClosestPoints, PointAndTriangleMatchAMinimisation) {
  RandomPoints random(2);
  std::map<TriangleFeature, int> seen;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto x = configuration<4>(random);
    const PointTriangle closest = closest_point_triangle(x);
    ++seen[closest.feature];
    expect_same(closest.squared_distance, point_triangle_reference(x), trial);
    EXPECT_NEAR(closest.barycentric[0] + closest.barycentric[1] + closest.barycentric[2], 1.0, 1e-15);
  }
  EXPECT_EQ(seen.size(), 7U);
}

TEST(ClosestPoints, TwoEdgesMatchAMinimisation) {
  RandomPoints random(3);
  std::map<std::tuple<EdgeFeature, EdgeFeature>, int> seen;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto x = configuration<4>(random);
    const EdgeEdge closest = closest_edge_edge(x);
    ++seen[{closest.a, closest.b}];
    expect_same(closest.squared_distance, edge_edge_reference(x), trial);
  }
  EXPECT_EQ(seen.size(), 9U);
}

TEST(ClosestPoints, ParallelEdgesHaveTheDistanceOfTheirLines) {
  const Points<4> x{{{0, 0, 0}, {1, 0, 0}, {-0.5, 0, 0.25}, {2, 0, 0.25}}};
  EXPECT_EQ(closest_edge_edge(x).squared_distance, 0.0625);
  const Points<4> in_line{{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}};
  const EdgeEdge closest = closest_edge_edge(in_line);
  EXPECT_EQ(closest.squared_distance, 1.0);
  EXPECT_EQ(closest.a, EdgeFeature::vertex_1);
  EXPECT_EQ(closest.b, EdgeFeature::vertex_1);
}

}  // namespace
}  // namespace pliant::test_closest_points
