#include "collision/distance.hpp"
#include "derivatives.hpp"

#include <map>

#include <gtest/gtest.h>

namespace pliant::test_distance {
namespace {

using namespace testing_collision;

Expansion<2> point_point(const Points<2>& x) {
  return squared_distance<2>(separation<2>(point_point_stencil(), x));
}
Expansion<3> point_edge(const Points<3>& x) {
  return squared_distance<3>(separation<3>(stencil_of(closest_point_edge(x)), x));
}
Expansion<4> point_triangle(const Points<4>& x) {
  return squared_distance<4>(separation<4>(stencil_of(closest_point_triangle(x)), x));
}
Expansion<4> edge_edge(const Points<4>& x) {
  return squared_distance<4>(separation<4>(stencil_of(closest_edge_edge(x)), x));
}

/// `feature_of`: numbers the case of a configuration; differences across two of them are left out, for the Hessian
/// jumps there.
template <int N, class F, class Feature>
void expect_derivatives(const F& f, const Feature& feature_of, int num_features, unsigned seed) {
  constexpr double step = 1e-5;
  RandomPoints random(seed);
  std::map<int, int> compared;
  for (int trial = 0; trial < 3000; ++trial) {
    Points<N> x = random.points<N>();
    if (trial % 3 == 1) {  // in one plane: d = 0 for some of them
      for (auto& p : x) p[2] = 0.0;
    }
    if (trial % 3 == 2) x[0] = x[N - 1] + random.point(0.01);
    const int feature = feature_of(x);
    bool is_inside = true;
    for (int i = 0; i < N; ++i) {
      for (int p = 0; p < 3; ++p) {
        for (const double sign : {-1.0, 1.0}) {
          Points<N> moved = x;
          moved[i][p] += 2.0 * sign * step;
          is_inside = is_inside && feature_of(moved) == feature;
        }
      }
    }
    const auto at = f(x);
    if (!is_inside || size_of_hessian(at) > 100.0 || size_of_gradient(at) < 1e-3)
      continue;  // nearly parallel, or touching
    const DerivativeErrors errors = compare_with_differences<N>(f, x, step);
    EXPECT_LT(errors.gradient, 1e-6) << "trial " << trial << ", feature " << feature;
    EXPECT_LT(errors.hessian, 1e-5) << "trial " << trial << ", feature " << feature;
    ++compared[feature];
  }
  EXPECT_EQ(static_cast<int>(compared.size()), num_features);
  for (const auto& [feature, number] : compared) EXPECT_GT(number, 30) << "feature " << feature;
}

TEST(Distance, DerivativesOfTwoPoints) {
  expect_derivatives<2>(
      point_point, [](const auto&) { return 0; }, 1, 1);
}
TEST(Distance, DerivativesOfAPointAndAnEdge) {
  const auto feature = [](const Points<3>& x) { return static_cast<int>(closest_point_edge(x).feature); };
  expect_derivatives<3>(point_edge, feature, 3, 2);
}
TEST(Distance, DerivativesOfAPointAndATriangle) {
  const auto feature = [](const Points<4>& x) { return static_cast<int>(closest_point_triangle(x).feature); };
  expect_derivatives<4>(point_triangle, feature, 7, 3);
}
TEST(Distance, DerivativesOfTwoEdges) {
  const auto feature = [](const Points<4>& x) {
    const EdgeEdge closest = closest_edge_edge(x);
    return 3 * static_cast<int>(closest.a) + static_cast<int>(closest.b);
  };
  expect_derivatives<4>(edge_edge, feature, 9, 4);
}

TEST(Distance, HessianHoldsWhereThePointTouchesTheTriangle) {
  const Points<4> x{{{0.25, 0.25, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Expansion<4> f = point_triangle(x);
  EXPECT_EQ(f.value, 0.0);
  EXPECT_EQ(f.block(0, 0)(2, 2), 2.0);  // d^2 = z^2
  EXPECT_EQ(f.block(0, 0)(0, 0), 0.0);
  EXPECT_EQ(f.block(0, 1)(2, 2), -1.0);
  EXPECT_EQ(f.block(1, 2)(2, 2), 0.25);
}

/// d^2 of a point and a plane, of lines, as their textbook forms with cross products have it.
TEST(Distance, AgreesWithTextbookForms) {
  RandomPoints random(5);
  int inside = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const auto x = random.points<4>();
    const auto face = closest_point_triangle(x);
    if (face.feature == TriangleFeature::face) {
      const auto n = cross(x[2] - x[1], x[3] - x[1]);
      EXPECT_NEAR(point_triangle(x).value, std::pow(dot(n, x[0] - x[1]), 2) / dot(n, n), 1e-12);
      ++inside;
    }
    const auto edges = closest_edge_edge(x);
    if (edges.a == EdgeFeature::inside && edges.b == EdgeFeature::inside) {
      const auto n = cross(x[1] - x[0], x[3] - x[2]);
      EXPECT_NEAR(edge_edge(x).value, std::pow(dot(n, x[0] - x[2]), 2) / dot(n, n), 1e-12);
      ++inside;
    }
  }
  EXPECT_GT(inside, 300);
}

/// A rotation or translation of all points changes nothing: forces and moments add up to zero.
TEST(Distance, GradientBalancesForcesAndMoments) {
  RandomPoints random(6);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto x = random.points<4>();
    for (const auto& f : {point_triangle(x), edge_edge(x)}) {
      Vector3<double> force{}, moment{};
      for (int i = 0; i < 4; ++i) {
        force = force + f.gradient[i];
        moment = moment + cross(x[i], f.gradient[i]);
      }
      EXPECT_LT(norm(force), 1e-14);
      EXPECT_LT(norm(moment), 1e-13);
    }
  }
}

/// A point of a triangle is a combination of three nodes.
TEST(Distance, CombinedPointHasTheDerivativesOfItsNodes) {
  const std::array<double, 3> point{0.2, 0.5, 0.3};
  const auto f = [&](const Points<6>& x) {
    const Points<4> simple{{point[0] * x[0] + point[1] * x[1] + point[2] * x[2], x[3], x[4], x[5]}};
    return squared_distance<6>(separation<6>(stencil_of<3>(point, closest_point_triangle(simple)), x));
  };
  RandomPoints random(7);
  int compared = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto x = random.points<6>();
    const auto at = f(x);
    if (size_of_hessian(at) > 20.0) continue;
    const DerivativeErrors errors = compare_with_differences<6>(f, x, 1e-6);
    EXPECT_LT(errors.gradient, 1e-6);
    compared += errors.hessian < 1e-4 ? 1 : 0;  // not across two features
  }
  EXPECT_GT(compared, 270);
}

}  // namespace
}  // namespace pliant::test_distance
