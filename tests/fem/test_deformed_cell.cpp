#include "fem/body.hpp"
#include "fem/deformed_cell.hpp"

#include <cmath>

namespace pliant::test_deformed_cell {
namespace {

using test::Body;
using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

class DeformedCells : public test::OnBodies {
 protected:
  std::vector<double> field(const std::function<Point(const Point&)>& at) const {
    std::vector<double> u;
    for (PetscInt a = 0; a < layout_.num_local_nodes; ++a) {
      for (const double value : at(layout_.position(a))) u.push_back(value);
    }
    return u;
  }
};

INSTANTIATE_TEST_SUITE_P(Bodies, DeformedCells,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 2},
                                           BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(DeformedCells, OfAnAffineMotionHaveItsVolumeRatio) {
  // F = [1.1 0.2 0; 0 0.8 0; 0.3 0 s], det F = 0.88 s
  for (const double s : {1.0, 0.1, -0.5}) {
    const auto u = field([&](const Point& X) {
      return Point{0.1 * X[0] + 0.2 * X[1], -0.2 * X[1], 0.3 * X[0] + (s - 1.0) * X[2]};
    });
    for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
      const DeformedCell cell = deformed_cell(layout_, c, u);
      EXPECT_NEAR(cell.volume_ratio, 0.88 * s, 1e-12);
      EXPECT_GT(cell.reference_quality, 0.05);
      EXPECT_EQ(cell.quality > 0.0, s > 0.0);  // 0 where it is inverted
      Point middle{};
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) middle[i] += layout_.position(layout_.nodes_of_cell(c)[a])[i] / 4.0;
      }
      EXPECT_EQ(cell.X, middle);
    }
  }
}

TEST_P(DeformedCells, AtRestAreWhatTheyWere) {
  const auto u = field([](const Point&) { return Point{0.5, -2.0, 1.0}; });
  for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
    const DeformedCell cell = deformed_cell(layout_, c, u);
    EXPECT_NEAR(cell.volume_ratio, 1.0, 1e-12);
    EXPECT_NEAR(cell.quality, cell.reference_quality, 1e-12);
  }
}

/// Quadratic elements on straight cells hold quadratic fields exactly.
class StraightQuadraticCells : public DeformedCells {};

INSTANTIATE_TEST_SUITE_P(Bodies, StraightQuadraticCells, ::testing::Values(BodySpec{2, Shape::jittered, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(StraightQuadraticCells, AreFoundWhereAMotionFoldsACornerOnly) {
  // u = -k X^2 / 2 in the direction of X: J = 1 - k X, below zero beyond X = 1/k, which lies inside the body.
  constexpr double k = 1.3;
  const auto u = field([](const Point& X) { return Point{-0.5 * k * X[0] * X[0], 0.0, 0.0}; });
  for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
    double farthest = 0.0;
    for (int a = 0; a < 4; ++a) farthest = std::max(farthest, layout_.position(layout_.nodes_of_cell(c)[a])[0]);
    EXPECT_NEAR(deformed_cell(layout_, c, u).volume_ratio, 1.0 - k * farthest, 1e-12);
  }
}

}  // namespace
}  // namespace pliant::test_deformed_cell
