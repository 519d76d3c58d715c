#include "base/vector3.hpp"
#include "fem/body.hpp"
#include "fem/probe.hpp"

#include <algorithm>

namespace pliant::test_probe {
namespace {

using test::Body;
using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

class Probes : public test::OnBodies {
 protected:
  /// What the probe reads from a field, on every rank; also that one rank holds it.
  Point read(const ProbeLocation& probe, const std::vector<double>& local) const {
    EXPECT_EQ(sum(comm, PetscInt64{probe.nodes.empty() ? 0 : 1}), 1);
    Point value = probe.interpolate(local);
    for (double& v : value) v = sum(comm, v);
    return value;
  }

  /// The positions on curved cells, beside them a field of the elements' degree.
  std::vector<double> field() const {
    std::vector<double> u;
    for (PetscInt a = 0; a < layout_.num_local_nodes; ++a) {
      for (const double value : field_at(layout_.position(a))) u.push_back(value);
    }
    return u;
  }
  Point field_at(const Point& x) const {
    const double c = GetParam().order == 2 && GetParam().shape != Shape::curved ? 1.0 : 0.0;
    return {x[0] - 2.0 * x[1] + c * x[0] * x[2], 3.0 * x[2] + c * x[1] * x[1], 1.0 + x[0] + x[1] + x[2]};
  }
};

INSTANTIATE_TEST_SUITE_P(Bodies, Probes,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 2},
                                           BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

/// Of edges of 0.5 and 0.7 m, where `bent` has second derivatives of 0.4 at most [m].
constexpr double sagitta = 0.4 * 0.5 / 8.0;

/// By looking at points 2 cm apart.
Point nearest_of_bent_surface(const Point& X) {
  constexpr int n = 50;
  Point nearest{HUGE_VAL, 0.0, 0.0};
  for (int side = 0; side < 6; ++side) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        Point xi{static_cast<double>(side % 2), static_cast<double>(i) / n, static_cast<double>(j) / n};
        std::ranges::rotate(xi, xi.begin() + side / 2);
        const Point x = test::bent(xi);
        if (norm(X - x) < norm(X - nearest)) nearest = x;
      }
    }
  }
  return nearest;
}

TEST_P(Probes, InsideReadTheField) {
  const auto u = field();
  for (const Point& xi : {Point{0.31, 0.47, 0.83}, {0.05, 0.02, 0.9}, {0.5, 0.5, 0.5}, {0.999, 0.7, 0.001}}) {
    const Point x = GetParam().shape == Shape::curved ? test::bent(xi) : xi;
    const auto probe = locate(layout_, x);
    EXPECT_EQ(probe.distance, 0.0);
    double total = 0.0;
    for (const double w : probe.weights) total += w;
    EXPECT_NEAR(sum(comm, total), 1.0, 1e-13);
    const Point expected = field_at(x), value = read(probe, u);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(value[k], expected[k], 1e-12);
  }
}

TEST_P(Probes, OnTheSurfaceAndAtCornersAreInside) {
  const auto u = field();
  for (const Point& xi :
       {Point{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {1.0, 0.0, 0.0}, {0.0, 0.37, 0.61}, {1.0, 0.37, 0.0}}) {
    const Point x = GetParam().shape == Shape::curved ? test::bent(xi) : xi;
    const auto probe = locate(layout_, x);
    EXPECT_EQ(probe.distance, 0.0);
    const Point expected = field_at(x), value = read(probe, u);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(value[k], expected[k], 1e-8);
  }
}

TEST_P(Probes, AtEveryNodeReadThatNode) {
  const auto u = field();
  const Body whole(MPI_COMM_SELF, file_, GetParam().order);  // the same list on every rank
  for (PetscInt a = 0; a < whole.layout.num_owned_nodes; a += 7) {
    const Point x = whole.layout.position(a);
    const auto probe = locate(layout_, x);
    EXPECT_EQ(probe.distance, 0.0);
    const Point expected = field_at(x), value = read(probe, u);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(value[k], expected[k], 1e-11);
  }
}

TEST_P(Probes, AtNodesAreInTheSameCellOnAnyRanks) {
  const Body whole(MPI_COMM_SELF, file_, GetParam().order);
  std::vector<Point> places{{1.3, 1.2, 1.1}, {0.5, 1.5, -0.5}, {-1.0, 0.5, 0.5}};  // outside: near several nodes
  for (PetscInt a = 0; a < whole.layout.num_owned_nodes; ++a) places.push_back(whole.layout.position(a));
  const auto number_of = [](const Body& body, const ProbeLocation& found) {
    return found.cell < 0 ? -1.0 : static_cast<double>(body.layout.cell_numbers[found.cell]);
  };
  const auto found = locate(layout_, places), expected = locate(whole.layout, places);
  for (std::size_t p = 0; p < places.size(); ++p) {
    EXPECT_EQ(maximum(comm, number_of(body_, found[p])), number_of(whole, expected[p]));
    const Point x = read(found[p], layout_.coordinates), y = expected[p].interpolate(whole.layout.coordinates);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(x[i], y[i], 1e-14);
  }
}

TEST_P(Probes, OutsideTakeTheNearestNodeAndSayHowFar) {
  const Point X{1.3, 1.2, 1.1};
  double nearest = HUGE_VAL;
  for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
    const Point x = layout_.position(a);
    nearest = std::min(nearest, std::hypot(x[0] - X[0], x[1] - X[1], x[2] - X[2]));
  }
  nearest = minimum(comm, nearest);
  const auto probe = locate(layout_, X);
  EXPECT_GT(probe.distance, 0.0);
  EXPECT_NEAR(probe.distance, nearest, 1e-14);
  const Point x = read(probe, layout_.coordinates);
  EXPECT_NEAR(std::hypot(x[0] - X[0], x[1] - X[1], x[2] - X[2]), nearest, 1e-14);
}

// Curved sides count as flat between their corners, which puts the nearest point off by less than their sagitta.
TEST_P(Probes, OutsideHaveANearestPointOfTheMesh) {
  const bool is_curved = GetParam().shape == Shape::curved;
  // Next to a corner, an edge and a face of the unit cube.
  for (const auto& [X, of_cube] : {std::pair{Point{1.3, 1.2, 1.1}, Point{1.0, 1.0, 1.0}},
                                   {Point{0.3, -2.0, 1.5}, Point{0.3, 0.0, 1.0}},
                                   {Point{0.3, 0.6, 1.5}, Point{0.3, 0.6, 1.0}}}) {
    const Point expected = is_curved ? nearest_of_bent_surface(X) : of_cube;
    const double tolerance = is_curved ? sagitta : 1e-12;
    const NearestOfMesh nearest = nearest_of_mesh(layout_, X);
    EXPECT_NEAR(nearest.distance, norm(X - nearest.point), 1e-12);
    EXPECT_NEAR(nearest.distance, norm(X - expected), tolerance);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(nearest.point[i], expected[i], is_curved ? 0.1 : 1e-12);
  }
}

}  // namespace
}  // namespace pliant::test_probe
