#include "collision/intersection.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>

namespace pliant::test_intersection {
namespace {

using testing_collision::RandomPoints;
using Triangle = std::array<Vector3<double>, 3>;
using Segment = std::array<Vector3<double>, 2>;
__extension__ typedef __int128 Integer;

/// Exact for coordinates that are multiples of 2^-20 below 2^10.
int exact_orientation(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c,
                      const Vector3<double>& d) {
  const auto difference = [&](const Vector3<double>& x) {
    std::array<Integer, 3> u;
    for (int k = 0; k < 3; ++k)
      u[k] = static_cast<Integer>(std::ldexp(x[k], 20)) - static_cast<Integer>(std::ldexp(a[k], 20));
    return u;
  };
  const auto u = difference(b), v = difference(c), w = difference(d);
  const Integer sum =
      (u[0] * v[1] - u[1] * v[0]) * w[2] + (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1];
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

TEST(Intersection, OrientationIsExact) {
  RandomPoints random(1);
  const auto on_grid = [](Vector3<double> x) {
    for (double& c : x) c = std::ldexp(std::round(std::ldexp(c, 20)), -20);
    return x;
  };
  std::array<int, 3> seen{};
  for (int trial = 0; trial < 50000; ++trial) {
    const auto a = on_grid(random.point(300.0)), b = on_grid(random.point(300.0)), c = on_grid(random.point(300.0));
    auto d = on_grid(random.point(300.0));
    if (trial % 2 == 0) {  // in the plane, to rounding
      d = on_grid(a + random.number(0.0, 1.0) * (b - a) + random.number(0.0, 1.0) * (c - a));
    } else if (trial % 3 == 0) {  // exactly
      d = a + (b - a) + (c - a);
    }
    const int sign = orientation(a, b, c, d);
    ASSERT_EQ(sign, exact_orientation(a, b, c, d)) << trial;
    ++seen[1 + sign];
  }
  for (const int number : seen) EXPECT_GT(number, 1000);
}

/// Far from the origin by the last digits of a double: the shift is exact, so that the sign stays.
TEST(Intersection, OrientationKeepsTheLastDigits) {
  const double last = std::ldexp(1.0, -52);
  const Vector3<double> a{1, 1, 1}, b{1 + last, 1, 1}, c{1, 1 + last, 1};
  EXPECT_EQ(orientation(a, b, c, {1, 1, 1 + last}), 1);
  EXPECT_EQ(orientation(a, b, c, {1, 1, 1 - 0.5 * last}), -1);
  EXPECT_EQ(orientation(a, b, c, {5, -3, 1}), 0);
  EXPECT_EQ(orientation({0.1, 0.1, 0.1}, {0.3, 0.3, 0.3}, {0.7, 0.7, 0.7}, {1e-9, 2, 3}), 0);  // in one line
  EXPECT_EQ(orientation({1e-30, 0, 0}, {1e30, 1e-30, 0}, {0, 1e30, 1e-30}, {1e30, 1e30, 1e-30}),
            -orientation({1e30, 1e-30, 0}, {1e-30, 0, 0}, {0, 1e30, 1e-30}, {1e30, 1e30, 1e-30}));
}

TEST(Intersection, OfASegmentAndATriangle) {
  const Triangle t{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const auto meets = [&](const Vector3<double>& p, const Vector3<double>& q) {
    const bool answer = segment_meets_triangle({p, q}, t);
    EXPECT_EQ(segment_meets_triangle({q, p}, t), answer);
    EXPECT_EQ(segment_meets_triangle({p, q}, {t[1], t[0], t[2]}), answer);
    EXPECT_EQ(segment_meets_triangle({p, q}, {t[1], t[2], t[0]}), answer);
    return answer;
  };
  EXPECT_TRUE(meets({0.2, 0.2, -1}, {0.3, 0.3, 1}));
  EXPECT_FALSE(meets({0.2, 0.2, 1e-300}, {0.3, 0.3, 1}));
  EXPECT_TRUE(meets({0.2, 0.2, 0}, {0.3, 0.3, 1}));   // touches
  EXPECT_TRUE(meets({0.5, 0.5, -1}, {0.5, 0.5, 1}));  // through an edge
  EXPECT_TRUE(meets({0, 0, -1}, {0, 0, 1}));          // through a vertex
  EXPECT_FALSE(meets({0.5, 0.5 + 1e-16, -1}, {0.5, 0.5 + 1e-15, 1}));
  EXPECT_TRUE(meets({0.1, 0.1, 0}, {0.2, 0.2, 0}));  // inside, in the plane
  EXPECT_TRUE(meets({-1, 0.5, 0}, {2, 0.4, 0}));     // across, in the plane
  EXPECT_TRUE(meets({-1, 0, 0}, {2, 0, 0}));         // along an edge
  EXPECT_FALSE(meets({1.5, 0, 0}, {2, 0, 0}));       // further along it
  EXPECT_FALSE(meets({0.6, 0.6, 0}, {2, 0.1, 0}));
  EXPECT_FALSE(meets({0.9, 0.9, -1}, {0.9, 0.9, 1}));  // past it
}

/// Against a search for the least distance in another way: parameters of the planes in higher precision.
TEST(Intersection, OfTrianglesMatchesTheLineThroughTheirPlanes) {
  using Long = long double;
  const auto pierces = [](const Vector3<double>& p, const Vector3<double>& q, const Triangle& t) {
    const auto widened = [](const Vector3<double>& x) { return Vector3<Long>{x[0], x[1], x[2]}; };
    const auto o = widened(t[0]), u = widened(t[1]) - o, v = widened(t[2]) - o, r = widened(p) - o;
    const auto d = widened(q) - widened(p), h = cross(d, v);
    const Long det = dot(u, h), a = dot(r, h) / det, b = dot(d, cross(r, u)) / det, s = dot(v, cross(r, u)) / det;
    return a >= 0 && b >= 0 && a + b <= 1 && s >= 0 && s <= 1;
  };
  RandomPoints random(2);
  int meeting = 0, apart = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Triangle a = random.points<3>(), b = random.points<3>();
    bool expected = false;
    for (int k = 0; k < 3; ++k) {
      expected = expected || pierces(a[k], a[(k + 1) % 3], b) || pierces(b[k], b[(k + 1) % 3], a);
    }
    ASSERT_EQ(triangles_meet(a, b), expected) << trial;
    ++(expected ? meeting : apart);
  }
  EXPECT_GT(meeting, 2000);
  EXPECT_GT(apart, 2000);
}

TEST(Intersection, OfTrianglesInOnePlane) {
  const Triangle t{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  EXPECT_TRUE(triangles_meet(t, {{{1, 1, 0}, {1.5, 1, 0}, {1, 1.5, 0}}}));  // one in the other
  EXPECT_TRUE(triangles_meet(t, {{{2, 2, 0}, {5, 2, 0}, {5, 5, 0}}}));      // touching
  EXPECT_FALSE(triangles_meet(t, {{{2.5, 2, 0}, {5, 2, 0}, {5, 5, 0}}}));   // beside
  EXPECT_FALSE(triangles_meet(t, {{{1, 1, 1e-300}, {1.5, 1, 1}, {1, 1.5, 1}}}));
}

}  // namespace
}  // namespace pliant::test_intersection
