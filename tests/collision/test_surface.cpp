#include "collision/candidates.hpp"
#include "collision/closest_points.hpp"
#include "surfaces.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

namespace pliant::test_surface {
namespace {

using namespace testing_collision;

TEST(Surface, OfACube) {
  const auto surface = cube().surface();
  EXPECT_EQ(surface.vertices().size(), 8U);
  EXPECT_EQ(surface.edges().size(), 18U);
  EXPECT_EQ(surface.triangles().size(), 12U);
  double vertex_area = 0, edge_area = 0;
  for (const auto& vertex : surface.vertices()) vertex_area += vertex.area;
  for (const auto& edge : surface.edges()) edge_area += edge.area;
  EXPECT_NEAR(vertex_area, 6.0, 1e-14);
  EXPECT_NEAR(edge_area, 6.0, 1e-14);
  EXPECT_NEAR(surface.longest_edge(), std::sqrt(2.0), 1e-15);
}

std::ptrdiff_t num_flat_edges(const CollisionSurface& surface) {
  return std::ranges::count_if(surface.edges(), [](const auto& edge) { return edge.is_flat; });
}

TEST(Surface, HasFlatEdgesInPlaneFacesOfOneRigidPart) {
  SurfaceInput input = cube();
  EXPECT_EQ(num_flat_edges(input.surface()), 0);  // it deforms
  for (auto& triangle : input.triangles) triangle.rigid_part = 1;
  EXPECT_EQ(num_flat_edges(input.surface()), 6);  // the diagonals
  input.vertices[7].X[2] += 1e-5;
  EXPECT_LT(num_flat_edges(input.surface()), 6);
  SurfaceInput plate = patch(4, 0.0, 0, 0, 3);
  for (auto& triangle : plate.triangles) triangle.rigid_part = 2;
  EXPECT_EQ(num_flat_edges(plate.surface()), 40);  // all but the 16 of the rim
  for (std::size_t t = 0; t < plate.triangles.size(); t += 2) plate.triangles[t].rigid_part = 1;
  EXPECT_LT(num_flat_edges(plate.surface()), 16);  // not those between two parts
}

TEST(Surface, DoesNotDependOnTheOrderOfItsInput) {
  SurfaceInput input = patch(5, 0.0, 0, 0, 3);
  const auto surface = input.surface();
  std::mt19937 engine(4);
  std::ranges::shuffle(input.vertices, engine);
  std::ranges::shuffle(input.triangles, engine);
  for (auto& triangle : input.triangles) std::ranges::rotate(triangle.vertices, triangle.vertices.begin() + 1);
  const auto shuffled = input.surface();
  for (std::size_t n = 0; n < surface.triangles().size(); ++n) {
    EXPECT_EQ(surface.triangles()[n].vertices, shuffled.triangles()[n].vertices);
    EXPECT_EQ(surface.triangles()[n].edges, shuffled.triangles()[n].edges);
    EXPECT_EQ(surface.triangles()[n].area, shuffled.triangles()[n].area);
  }
  for (std::size_t n = 0; n < surface.edges().size(); ++n) {
    EXPECT_EQ(surface.edges()[n].vertices, shuffled.edges()[n].vertices);
    EXPECT_EQ(surface.edges()[n].area, shuffled.edges()[n].area);
  }
}

TEST(Surface, RefusesWhatIsNoSurface) {
  const std::vector<SurfaceVertex> vertices{{0, {0, 0, 0}}, {1, {1, 0, 0}}, {2, {0, 1, 0}}};
  const auto make = [&](const std::vector<SurfaceVertex>& v, std::array<VertexKey, 3> t) {
    return CollisionSurface(v, std::vector<SurfaceTriangle>{{t, 0, 0}});
  };
  EXPECT_THROW(make(vertices, {0, 1, 3}), std::invalid_argument);
  EXPECT_THROW(make(vertices, {0, 1, 1}), std::invalid_argument);  // a segment has a thickness
  EXPECT_THROW(make({vertices[0], vertices[0], vertices[1], vertices[2]}, {0, 1, 2}), std::invalid_argument);
  EXPECT_EQ(make(vertices, {0, 1, 2}).vertices().size(), 3U);
}

TEST(Surface, OfARod) {
  const std::vector<SurfaceVertex> vertices{{7, {0, 0, 0}}, {3, {2, 0, 0}}, {5, {2, 1, 0}}};
  const std::vector<SurfaceTriangle> segments{{{7, 3, 3}, 0, 0, 0.1}, {{3, 5, 5}, 0, 0, 0.1}, {{5, 3, 3}, 1, 0, 0.1}};
  const CollisionSurface surface(vertices, segments);
  ASSERT_EQ(surface.triangles().size(), 2U);  // one segment of two rods is there once
  ASSERT_EQ(surface.edges().size(), 2U);
  double vertex_area = 0, edge_area = 0;
  for (const auto& vertex : surface.vertices()) vertex_area += vertex.area;
  for (const auto& edge : surface.edges()) {
    edge_area += edge.area;
    EXPECT_TRUE(edge.is_loose);
  }
  EXPECT_NEAR(vertex_area, 0.3, 1e-15);
  EXPECT_NEAR(edge_area, 0.3, 1e-15);
  for (const auto& triangle : surface.triangles()) {
    EXPECT_TRUE(triangle.is_segment());
    EXPECT_EQ(triangle.corners().size(), 2U);
    EXPECT_EQ(triangle.sides().size(), 1U);
  }
}

/// Along the surface, over a distance that depends on the bodies; not across a gap, however narrow.
TEST(Surface, NeighboursHangTogether) {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> segments;
  for (VertexKey n = 0; n < 10; ++n) {  // there and back, 0.1 beside it
    vertices.push_back({n, {n < 5 ? double(n) : double(9 - n), n < 5 ? 0.0 : 0.1, 0}});
    if (n > 0) segments.push_back({{n - 1, n, n}, n < 5 ? 0 : 1, 0, 0.1});
  }
  const CollisionSurface surface(vertices, segments);
  const SurfaceNeighbours neighbours(surface, 2, {2.5, 1.5, 1.5, 0.0});
  const auto are = [&](std::int32_t a, std::int32_t b) { return neighbours.include(std::array{a}, std::array{b}); };
  EXPECT_TRUE(are(0, 1));
  EXPECT_TRUE(are(0, 2) && are(2, 0));
  EXPECT_FALSE(are(0, 3));
  EXPECT_FALSE(are(0, 9));
  EXPECT_FALSE(are(5, 6));
  EXPECT_TRUE(are(3, 5));
  EXPECT_TRUE(neighbours.include(std::array{0, 1}, std::array{3, 4}));
  EXPECT_TRUE(SurfaceNeighbours(surface, 2, {0.0, 0.0, 0.0, 0.0}).empty());
  EXPECT_TRUE(SurfaceNeighbours().empty());
}

/// All pairs that share no vertex, by their distances.
Candidates within(const CollisionSurface& surface, std::span<const Vector3<double>> x, double distance) {
  Candidates pairs;
  for (std::int32_t v = 0; v < std::ssize(surface.vertices()); ++v) {
    for (std::int32_t t = 0; t < std::ssize(surface.triangles()); ++t) {
      const auto& [a, b, c] = surface.triangles()[t].vertices;
      if (v == a || v == b || v == c) continue;
      if (closest_point_triangle(Points<4>{x[v], x[a], x[b], x[c]}).squared_distance <= distance * distance) {
        pairs.point_triangle.push_back({v, t});
      }
    }
  }
  for (std::int32_t e = 0; e < std::ssize(surface.edges()); ++e) {
    for (std::int32_t f = e + 1; f < std::ssize(surface.edges()); ++f) {
      const auto [a, b] = surface.edges()[e].vertices;
      const auto [c, d] = surface.edges()[f].vertices;
      if (std::set{a, b, c, d}.size() < 4) continue;
      if (closest_edge_edge(Points<4>{x[a], x[b], x[c], x[d]}).squared_distance <= distance * distance) {
        pairs.edge_edge.push_back({e, f});
      }
    }
  }
  return pairs;
}

TEST(Candidates, HoldAllPairsWithinTheDistance) {
  const auto surface = joined(patch(8, 0.0, 0, 0, 5), patch(7, 0.05, 1000, 1, 6)).surface();
  const auto X = surface.rest_positions();
  std::vector<Vector3<double>> x(X.begin(), X.end()), y = x;
  for (auto& p : y) p[2] += 0.1 * std::sin(7 * p[0]) * p[1];
  BroadPhase phase(surface, x, x, 0.06);
  for (const bool moved : {false, true}) {
    if (moved) phase.refit(surface, y, y, 0.06);
    const auto near = within(surface, moved ? y : x, 0.06);
    const auto found = phase.candidates(surface);
    EXPECT_TRUE(std::ranges::includes(found.point_triangle, near.point_triangle));
    EXPECT_TRUE(std::ranges::includes(found.edge_edge, near.edge_edge));
    EXPECT_GT(near.point_triangle.size(), 100U);
    EXPECT_LT(found.point_triangle.size(), 8 * near.point_triangle.size());
    EXPECT_TRUE(std::ranges::is_sorted(found.edge_edge));
  }
}

/// A surface that passes through another on its way meets it in neither end.
TEST(Candidates, HoldPairsThatMeetOnTheWay) {
  const auto surface = joined(patch(3, 0.0, 0, 0, 7), patch(3, 1.0, 1000, 1, 8)).surface();
  const auto X = surface.rest_positions();
  std::vector<Vector3<double>> y(X.begin(), X.end());
  for (std::size_t n = 0; n < y.size(); ++n) {
    if (surface.vertices()[n].body == 1) y[n][2] = -1.0;
  }
  const auto has_pair_of_both = [&](const Candidates& found) {
    return std::ranges::any_of(found.point_triangle, [&](const BoxPair& pair) {
      return surface.vertices()[pair.first].body != surface.triangles()[pair.second].body;
    });
  };
  EXPECT_TRUE(has_pair_of_both(BroadPhase(surface, X, y, 0.01).candidates(surface)));
  EXPECT_FALSE(has_pair_of_both(BroadPhase(surface, X, X, 0.01).candidates(surface)));
}

TEST(Candidates, LeastDistancesAreThoseOfEachTwoBodies) {
  const auto surface = joined(patch(2, 0.0, 0, 0, 9, 0.0), patch(2, 0.01, 1000, 1, 10, 0.0)).surface();
  const auto far = least_distances(surface, surface.rest_positions(), 2, 10.0);
  EXPECT_NEAR(far[1], 0.01, 1e-15);
  EXPECT_EQ(far[1], far[2]);
  EXPECT_NEAR(far[0], far[3], 0.1);
  EXPECT_GT(far[0], 0.3);  // across one triangle
  const auto near = least_distances(surface, surface.rest_positions(), 2, 0.02);
  EXPECT_EQ(near[0], 0.02);
  EXPECT_EQ(near[1], far[1]);
}

TEST(Candidates, IntersectionsAreThoseOfTheSurfaces) {
  const auto surface = joined(patch(4, 0.0, 0, 0, 11), patch(4, 0.1, 1000, 1, 12)).surface();
  const auto X = surface.rest_positions();
  EXPECT_TRUE(find_intersections(surface, X).empty());
  std::vector<Vector3<double>> x(X.begin(), X.end());
  for (std::size_t n = 0; n < x.size(); ++n) {
    if (surface.vertices()[n].body == 1 && x[n][0] > 0.4 && x[n][0] < 0.6) x[n][2] = -0.05;
  }
  const auto found = find_intersections(surface, x);
  EXPECT_FALSE(found.empty());
  for (const auto& pair : found) EXPECT_NE(surface.edges()[pair.first].body, surface.triangles()[pair.second].body);
}

}  // namespace
}  // namespace pliant::test_surface
