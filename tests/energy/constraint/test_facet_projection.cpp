// The projection of a surface's motion onto the facets of another mesh: what it reproduces, and what it conserves.
#include "energy/constraint/facet_projection.hpp"
#include "fem/element.hpp"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

namespace pliant::test_facet_projection {
namespace {

using Shape = Vector3<double> (*)(const Vector3<double>&);

Vector3<double> flat(const Vector3<double>& X) {
  return X;
}
Vector3<double> bulged(const Vector3<double>& X) {
  return {X[0] + 0.03 * X[1] * X[2], X[1], X[2] + 0.2 * X[0] * (1.0 - X[0]) + 0.1 * X[1] * X[1]};
}
/// The image of a flat triangle or tetrahedron: nodes at the corners, of order 2 also at the images of the edges'
/// middles.
template <std::size_t N>
std::vector<Vector3<double>> nodes_of(const std::array<Vector3<double>, N>& corners, int order, Shape shape) {
  std::vector<Vector3<double>> nodes(corners.begin(), corners.end());
  const auto add = [&](const auto& edges) {
    for (const auto& [i, j] : edges) nodes.push_back(0.5 * (corners[i] + corners[j]));
  };
  if (order == 2 && N == 3) add(triangle_edges);
  if (order == 2 && N == 4) add(tet_edges);
  for (auto& X : nodes) X = shape(X);
  return nodes;
}

/// The unit square at z = 0 in n x n x 2 triangles, with cells below it.
struct Square {
  std::vector<FacetOfCell> facets;
  std::vector<Vector3<double>> positions;  // by node

  Square(int n, int order, Shape shape) {
    std::map<std::array<long, 3>, PetscInt> number;
    const auto node = [&](const Vector3<double>& X) {
      const auto [place, is_new] = number.try_emplace(
          {std::lround(1e8 * X[0]), std::lround(1e8 * X[1]), std::lround(1e8 * X[2])}, positions.size());
      if (is_new) positions.push_back(X);
      return place->second;
    };
    const double h = 1.0 / n;
    for (int k = 0; k < n * n; ++k) {
      const double x = h * (k % n), y = h * (k / n);  // NOLINT(bugprone-integer-division)
      for (const bool is_upper : {false, true}) {
        const Vector3<double> a{x, y, 0.0}, b{x + h, y + h, 0.0}, c{is_upper ? x : x + h, is_upper ? y + h : y, 0.0};
        const Vector3<double> apex{x + 0.4 * h, y + 0.5 * h, -h};
        const auto nodes = nodes_of(std::array{a, is_upper ? b : c, is_upper ? c : b, apex}, order, shape);
        FacetOfCell& facet = facets.emplace_back();
        facet.nodes_per_cell = static_cast<std::int32_t>(nodes.size());
        facet.opposite = 3;
        for (std::size_t j = 0; j < nodes.size(); ++j) {
          facet.positions[j] = nodes[j];
          facet.nodes[j] = node(nodes[j]);
        }
      }
    }
  }
};

/// The unit square in four triangles around an inner point, facing down, at a height above it.
std::vector<std::array<Vector3<double>, 3>> four_triangles(double gap) {
  const Vector3<double> a{0, 0, gap}, b{1, 0, gap}, c{1, 1, gap}, d{0, 1, gap}, m{0.37, 0.58, gap};
  return {{b, a, m}, {c, b, m}, {d, c, m}, {a, d, m}};
}

class Projection : public testing::TestWithParam<int> {};

TEST_P(Projection, ReproducesEveryLinearMotionOnCurvedSurfacesAndAcrossGaps) {
  const int order = GetParam();
  for (const Shape shape : {Shape{flat}, Shape{bulged}}) {
    const Square square(3, order, shape);
    const IndependentSurface onto(square.facets);
    for (const double gap : {0.0, 0.02, -0.01}) {
      for (const auto& triangle : four_triangles(gap)) {
        const auto nodes = nodes_of(triangle, order, shape);
        const auto projection = project(nodes, onto, 0.06);
        ASSERT_TRUE(projection);
        for (std::size_t k = 0; k < nodes.size(); ++k) {
          Vector3<double> sum{};
          double ones = 0.0;
          for (const auto& [node, weight] : projection->weights[k]) {
            sum = sum + weight * square.positions[static_cast<std::size_t>(node)];
            ones += weight;
          }
          EXPECT_NEAR(ones, 1.0, 1e-13);
          EXPECT_LT(norm(sum - nodes[k]), 1e-13);
        }
      }
    }
  }
}

// The tractions of a constant stress reach every node as if it had been applied there: patch test.
TEST_P(Projection, ConservesIntegralsOverAFlatSurface) {
  const int order = GetParam();
  for (const int n : {1, 2, 5}) {
    const Square square(n, order, flat);
    const IndependentSurface onto(square.facets);
    std::map<PetscInt, double> received;
    double missing = 1.0;
    for (const auto& triangle : four_triangles(0.0)) {
      const auto nodes = nodes_of(triangle, order, flat);
      const auto projection = project(nodes, onto, 0.01);
      ASSERT_TRUE(projection);
      missing -= projection->area;
      for (std::size_t k = order == 1 ? 0 : 3; k < nodes.size(); ++k) {
        for (const auto& [node, weight] : projection->weights[k]) {
          received[node] += projection->area / 3.0 * weight;
        }
      }
    }
    EXPECT_NEAR(missing, 0.0, 1e-14);
    for (const FacetOfCell& facet : square.facets) {
      for (const int k : order == 1 ? std::array{0, 1, 2} : std::array{4, 5, 6}) {  // the edges of the facet
        received[facet.nodes[static_cast<std::size_t>(k)]] -= 0.5 / (n * n) / 3.0;
      }
    }
    for (const auto& [node, difference] : received) EXPECT_NEAR(difference, 0.0, 1e-14) << "node " << node;
  }
}

TEST_P(Projection, LeavesOutWhatIsBeyondTheTolerance) {
  const Square square(2, GetParam(), flat);
  const IndependentSurface onto(square.facets);
  const auto at = [&](double x, double z) {
    const std::array<Vector3<double>, 3> corners{{{x + 0.4, 0.2, z}, {x, 0.2, z}, {x, 0.6, z}}};
    return project(nodes_of(corners, GetParam(), flat), onto, 0.05);
  };
  EXPECT_TRUE(at(0.3, 0.049));
  EXPECT_FALSE(at(0.3, 0.051));
  EXPECT_FALSE(at(0.3, -0.051));
  EXPECT_TRUE(at(0.7, 0.0));    // juts out, by less than half of it
  EXPECT_FALSE(at(0.95, 0.0));  // by more
}

INSTANTIATE_TEST_SUITE_P(Orders, Projection, testing::Values(1, 2));

TEST(IndependentSurface, MeasuresDistancesToCurvedFacets) {
  const Square square(4, 2, bulged);
  const IndependentSurface surface(square.facets);
  // A point of a curved facet, between its nodes, and one in the direction in which the cells end.
  const FacetOfCell& facet = square.facets[11];
  Vector3<double> X{};
  const auto N = Tet<2>::values({0.21, 0.33, 0.0});
  // The facet lacks corner 3, so its points have xi_3 = 0.
  for (std::size_t j = 0; j < 10; ++j) X = X + N[j] * facet.positions[j];
  EXPECT_LT(surface.distance(X), 1e-12);
  EXPECT_NEAR(surface.distance(X + Vector3<double>{0.0, 0.0, 3.0}), 3.0, 0.4);
  EXPECT_FALSE(surface.nearest(X + Vector3<double>{0.0, 0.0, 0.5}, 0.1));
}

TEST(Polygons, CoverAreDisjointAndComplete) {
  std::vector<Polygon> uncovered{{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}}, covered;
  const std::array<PlanePoint, 3> first{{{-0.1, -0.2}, {0.7, 0.1}, {0.2, 0.6}}},
      second{{{0.1, 0.1}, {0.9, 0.05}, {0.3, 0.5}}};
  cover(first, uncovered, covered);
  const auto total = [](const std::vector<Polygon>& all) {
    double sum = 0.0;
    for (const Polygon& polygon : all) sum += area(polygon);
    return sum;
  };
  EXPECT_GT(total(covered), 0.1);
  EXPECT_NEAR(total(covered) + total(uncovered), 0.5, 1e-15);
  const double before = total(covered);
  cover(first, uncovered, covered);
  EXPECT_EQ(total(covered), before);
  cover(second, uncovered, covered);
  EXPECT_GT(total(covered), before + 0.001);
  EXPECT_NEAR(total(covered) + total(uncovered), 0.5, 1e-15);
  for (const Polygon& polygon : covered) EXPECT_GT(area(polygon), 0.0);
}

}  // namespace
}  // namespace pliant::test_facet_projection
