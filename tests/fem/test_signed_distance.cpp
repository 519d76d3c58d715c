// Distances to every shape: derivatives, sign, Lipschitz bound, closed forms, and surfaces for pictures.
#include "fem/shapes.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace pliant::test_signed_distance {
namespace {

using test::ShapeCase;

Vector3<double> moved(Vector3<double> x, std::size_t i, double h) {
  x[i] += h;
  return x;
}

class Distances : public ::testing::TestWithParam<ShapeCase> {
 protected:
  /// Around the shape and within; none so near to an edge of the distance that differences reach across.
  std::vector<Vector3<double>> points() const {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1.5, 1.5);
    std::vector<Vector3<double>> result;
    for (int k = 0; k < 1000; ++k) result.push_back({0.5 + uniform(random), 0.5 + uniform(random), uniform(random)});
    return result;
  }

  std::unique_ptr<SignedDistance> shape_ = GetParam().make();
};

INSTANTIATE_TEST_SUITE_P(EveryShape, Distances, ::testing::ValuesIn(test::every_shape()),
                         [](const auto& of) { return of.param.name; });

// Central differences over 1e-6: errors of 1e-12, rounding of 1e-10.
TEST_P(Distances, DerivativesAreThoseOfTheDistance) {
  constexpr double h = 1e-6, tolerance = 1e-8;
  int num_outside = 0, num_inside = 0;
  for (const auto& x : points()) {
    const DistanceAt at = shape_->at(x);
    ++(at.d > 0.0 ? num_outside : num_inside);
    EXPECT_NEAR(at.d, shape_->distance(x), 1e-15);
    EXPECT_NEAR(norm(at.n), 1.0, 1e-14);
    EXPECT_LE(norm(matvec(at.curvature, at.n)), 1e-13 * (1.0 + std::abs(trace(at.curvature))));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto ahead = moved(x, i, h), behind = moved(x, i, -h);
      EXPECT_NEAR((shape_->distance(ahead) - shape_->distance(behind)) / (2.0 * h), at.n[i], tolerance);
      const auto change = shape_->at(ahead).n - shape_->at(behind).n;
      for (std::size_t j = 0; j < 3; ++j) {
        const double curvature = at.curvature(static_cast<int>(j), static_cast<int>(i));
        EXPECT_NEAR(change[j] / (2.0 * h), curvature, tolerance * (1.0 + curvature * curvature))
            << "at distance " << at.d;
      }
    }
  }
  EXPECT_GT(num_outside, 15);
  EXPECT_GT(num_inside, 15);
}

TEST_P(Distances, CurvatureHasOneSign) {
  const double sign = GetParam().is_hollow ? -1.0 : 1.0;
  for (const auto& x : points()) {
    const Tensor3<double> C = shape_->at(x).curvature;
    EXPECT_GE(sign * trace(C), 0.0);
    EXPECT_GE(second_invariant(C), -1e-12 * (1.0 + trace(C) * trace(C)));  // one eigenvalue is 0: both others, or none
  }
}

TEST_P(Distances, ChangesNoFasterThanThePointMoves) {
  const auto at = points();
  for (std::size_t k = 1; k < at.size(); ++k) {
    EXPECT_LE(std::abs(shape_->distance(at[k]) - shape_->distance(at[k - 1])), norm(at[k] - at[k - 1]) * (1.0 + 1e-12));
  }
}

// Corners of the triangles lie on the surface itself, their middles within it.
TEST_P(Distances, SurfaceIsDrawnWhereTheDistanceIsZeroAndLooksOut) {
  const auto surface = shape_->drawing({0.5, -2.0, 1.0}, 3.0);
  ASSERT_GE(surface.size(), 2U);
  for (const auto& [a, b, c] : surface) {
    const auto middle = (1.0 / 3) * (a + b + c), normal = cross(b - a, c - a);
    for (const auto& corner : {a, b, c}) EXPECT_LE(std::abs(shape_->distance(corner)), 1e-12);
    if (norm(normal) > 1e-12) {
      EXPECT_GT(dot(normal, shape_->at(middle).n), 0.0);
    }
  }
}

TEST(Distance, WhatIsUnboundedIsDrawnNextToAPoint) {
  const Vector3<double> middle{10.0, 20.0, 30.0};
  const auto farthest = [&](const SignedDistance& shape) {
    double result = 0.0;
    for (const auto& triangle : shape.drawing(middle, 2.0)) {
      for (const auto& corner : triangle) result = std::max(result, norm(corner - middle));
    }
    return result;
  };
  EXPECT_NEAR(farthest(*make_distance(PlaneShape{{1.0, 2.0, 0.0}, {0.0, 0.0, 1.0}})), std::hypot(30.0, 2.0, 2.0),
              1e-12);
  EXPECT_NEAR(farthest(*make_distance(CylinderShape{{10.0, 1.0, 30.0}, {0.0, 1.0, 0.0}, 0.5})), std::hypot(2.0, 0.5),
              1e-12);
}

TEST(Distance, IsThatOfClosedForms) {
  const auto box = make_distance(BoxShape{{1.0, 0.0, 0.0}, {2.0, 4.0, 6.0}});
  EXPECT_NEAR(box->distance({5.0, 6.0, 0.0}), 5.0, 1e-14);                          // 3, 4, - from an edge
  EXPECT_NEAR(box->distance({4.0, 5.0, 9.0}), std::sqrt(4.0 + 9.0 + 36.0), 1e-14);  // 2, 3, 6 from a corner
  EXPECT_NEAR(box->distance({1.5, 0.0, 0.0}), -0.5, 1e-14);
  const auto cylinder = make_distance(CylinderShape{{0.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, 2.0, 4.0});
  EXPECT_NEAR(cylinder->distance({5.0, 0.0, 7.0}), 5.0, 1e-14);  // 3, 4 from the rim
  EXPECT_NEAR(cylinder->distance({0.5, 0.0, 1.0}), -1.5, 1e-14);
  EXPECT_NEAR(cylinder->distance({0.5, 0.0, 2.8}), -0.2, 1e-14);
  const auto capsule = make_distance(CapsuleShape{{0.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, 2.0, 4.0});
  EXPECT_NEAR(capsule->distance({3.0, 0.0, 7.0}), 3.0, 1e-14);  // 3, 4 from the centre of an end
  EXPECT_NEAR(capsule->distance({3.0, 0.0, -0.5}), 1.0, 1e-14);
}

}  // namespace
}  // namespace pliant::test_signed_distance
