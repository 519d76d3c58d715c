#include "collision/candidates.hpp"
#include "collision/triangle_tree.hpp"
#include "surfaces.hpp"

#include <numeric>

namespace pliant::test_triangle_tree {
namespace {

using testing_collision::cube;
using testing_collision::joined;
using testing_collision::patch;
using testing_collision::RandomPoints;
using testing_collision::SurfaceInput;

TriangleTree tree_of(const CollisionSurface& surface, std::span<const Vector3<double>> x, std::int32_t body) {
  std::vector<std::int32_t> numbers;
  for (std::size_t t = 0; t < surface.triangles().size(); ++t) {
    if (surface.triangles()[t].body == body) numbers.push_back(static_cast<std::int32_t>(t));
  }
  return {surface, x, numbers};
}

bool always(std::int32_t, std::int32_t) {
  return true;
}

/// The same surface with other keys.
SurfaceInput renumbered(SurfaceInput input, VertexKey last) {
  for (auto& vertex : input.vertices) vertex.key = last - vertex.key;
  for (auto& triangle : input.triangles) {
    for (auto& key : triangle.vertices) key = last - key;
  }
  return input;
}

TEST(TriangleTree, FindsTheLeastDistanceOfAllPairs) {
  RandomPoints random(3);
  for (const double lift : {0.05, 0.4, 3.0}) {
    const auto input = joined(patch(6, 0.0, 0, 0, 1), patch(5, lift, 1000, 1, 2));
    const auto surface = input.surface();
    std::vector<Vector3<double>> x(surface.rest_positions().begin(), surface.rest_positions().end());
    for (auto& p : x) p = p + random.point(0.3 * std::min(lift, 0.3));
    const auto all = least_distances(surface, x, 2, 100.0);
    const auto nearest = nearest_places(tree_of(surface, x, 0), tree_of(surface, x, 1), 100.0, always);
    EXPECT_NEAR(nearest.distance, all[1], 1e-12);
    EXPECT_EQ(nearest.body + nearest.other, 1);
    const auto none = nearest_places(tree_of(surface, x, 0), tree_of(surface, x, 1), 0.999 * all[1], always);
    EXPECT_EQ(none.distance, std::numeric_limits<double>::infinity());
    const auto excluded = nearest_places(tree_of(surface, x, 0), tree_of(surface, x, 1), 100.0,
                                         [](std::int32_t, std::int32_t) { return false; });
    EXPECT_EQ(excluded.distance, std::numeric_limits<double>::infinity());
  }
}

TEST(TriangleTree, ParallelSurfacesAreNearestAtOnePlaceWhateverTheNumbers) {
  const auto input = joined(patch(6, 0.0, 0, 0, 1), patch(5, 0.125, 1000, 1, 2));
  std::vector<NearestPlaces> found;
  for (const auto& one : {input, renumbered(input, 5000)}) {
    const auto surface = one.surface();
    const auto x = surface.rest_positions();
    found.push_back(nearest_places(tree_of(surface, x, 0), tree_of(surface, x, 1), 10.0, always));
    found.push_back(nearest_places(tree_of(surface, x, 1), tree_of(surface, x, 0), 10.0, always));
  }
  for (const auto& one : found) {
    EXPECT_NEAR(one.distance, 0.125, 1e-15);
    EXPECT_TRUE(one.is_vertex);
    EXPECT_EQ(one.place, found[0].place);
  }
}

TEST(TriangleTree, PlacesOfOneBodyCountOnceTheyHaveComeNearer) {
  const auto surface = joined(patch(3, 0.0, 0, 0, 1), patch(3, 1.0, 1000, 0, 2)).surface();
  std::vector<Vector3<double>> x(surface.rest_positions().begin(), surface.rest_positions().end());
  for (const auto& [height, is_near] : {std::pair(0.6, false), std::pair(0.4, true)}) {
    for (auto& p : x) p[2] = p[2] > 0.0 ? height : 0.0;
    const TriangleTree tree = tree_of(surface, x, 0);
    EXPECT_EQ(nearest_places(tree, tree, 10.0, always).distance < 10.0, is_near) << height;
  }
}

TEST(TriangleTree, DepthBelowACube) {
  const auto surface = cube().surface();
  const TriangleTree tree = tree_of(surface, surface.rest_positions(), 0);
  const DepthBelow depth(tree);
  EXPECT_TRUE(depth.is_closed());
  RandomPoints random(7);
  int num_inside = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3<double> p = Vector3<double>{0.5, 0.5, 0.5} + random.point(0.9);
    double expected = 1.0;
    for (const double c : p) expected = std::min({expected, c, 1.0 - c});
    num_inside += expected > 0.0 ? 1 : 0;
    EXPECT_NEAR(depth(p), std::max(0.0, expected), 1e-14);
  }
  EXPECT_GT(num_inside, 100);
}

TEST(TriangleTree, AnOpenSurfaceHasNoDepthBeyondItsRim) {
  const auto surface = patch(4, 0.0, 0, 0, 1).surface();
  const TriangleTree tree = tree_of(surface, surface.rest_positions(), 0);
  const DepthBelow depth(tree);
  EXPECT_FALSE(depth.is_closed());
  EXPECT_NEAR(depth({0.4, 0.6, -0.1}), 0.1, 1e-15);
  EXPECT_EQ(depth({0.4, 0.6, 0.1}), 0.0);
  EXPECT_EQ(depth({1.5, 0.5, -0.1}), 0.0);
}

}  // namespace
}  // namespace pliant::test_triangle_tree
