#include "collision/overlaps.hpp"
#include "surfaces.hpp"

namespace pliant::test_overlaps {
namespace {

using testing_collision::cube;
using testing_collision::joined;
using testing_collision::patch;
using testing_collision::SurfaceInput;

SurfaceInput cube_at(const Vector3<double>& low, double size, VertexKey first_key, std::int32_t body) {
  SurfaceInput input = cube();
  for (auto& vertex : input.vertices) {
    vertex.key += first_key;
    vertex.X = low + size * vertex.X;
  }
  for (auto& triangle : input.triangles) {
    for (auto& key : triangle.vertices) key += first_key;
    triangle.body = body;
    triangle.group = body;
  }
  return input;
}

ContactSets all_of(int n) {
  return {n, std::vector<char>(static_cast<std::size_t>(n * n), 1)};
}

TEST(Overlaps, ACornerInACube) {
  const auto surface = joined(cube_at({0, 0, 0}, 1.0, 0, 0), cube_at({0.75, 0.75, 0.875}, 1.0, 100, 1)).surface();
  const auto found = find_overlaps(surface, surface.rest_positions(), all_of(2));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].body, 0);
  EXPECT_EQ(found[0].other, 1);
  EXPECT_EQ(found[0].num_places, 1);
  EXPECT_DOUBLE_EQ(found[0].depth, 0.125);
  ContactSets none = all_of(2);
  none.may_touch = {1, 0, 0, 1};
  EXPECT_TRUE(find_overlaps(surface, surface.rest_positions(), none).empty());
}

TEST(Overlaps, TwoCornersAreTwoPlaces) {
  const auto one = joined(cube_at({0, 0, 0}, 1.0, 0, 0), cube_at({0.9, 0.9, 0.9}, 1.0, 100, 1));
  const auto two = joined(cube_at({5, 0, 0}, 1.0, 200, 0), cube_at({5.9, 0.9, 0.8}, 1.0, 300, 1));
  const auto surface = joined(one, two).surface();
  const auto found = find_overlaps(surface, surface.rest_positions(), all_of(2));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_places, 2);
  EXPECT_NEAR(found[0].depth, 0.1, 1e-15);
}

TEST(Overlaps, ACubeInACube) {
  const auto surface = joined(cube_at({0, 0, 0}, 1.0, 0, 0), cube_at({0.25, 0.375, 0.25}, 0.25, 100, 1)).surface();
  const auto found = find_overlaps(surface, surface.rest_positions(), all_of(2));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].triangles.size(), 12u);
  EXPECT_EQ(found[0].num_places, 1);
  EXPECT_NEAR(found[0].depth, 0.5, 1e-15);
  for (const auto& triangle : found[0].triangles) EXPECT_EQ(surface.triangles()[triangle.number].body, 1);
}

TEST(Overlaps, CubesThatTouchHaveNoDepth) {
  const auto surface = joined(cube_at({0, 0, 0}, 1.0, 0, 0), cube_at({0.25, 0.25, 1}, 0.5, 100, 1)).surface();
  const auto found = find_overlaps(surface, surface.rest_positions(), all_of(2));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].depth, 0.0);
  EXPECT_EQ(found[0].place[2], 1.0);
}

TEST(Overlaps, CubesApartAndSideBySideDoNotOverlap) {
  const auto surface = joined(cube_at({0, 0, 0}, 1.0, 0, 0), cube_at({1.001, 0.5, 0.5}, 1.0, 100, 1)).surface();
  EXPECT_TRUE(find_overlaps(surface, surface.rest_positions(), all_of(2)).empty());
}

TEST(Overlaps, ASurfaceThroughItself) {
  auto input = joined(patch(2, 0.0, 0, 0, 1), patch(3, 1.0, 1000, 0, 2));
  const auto surface = input.surface();
  std::vector<Vector3<double>> x(surface.rest_positions().begin(), surface.rest_positions().end());
  for (auto& p : x) {
    if (p[2] == 1.0) p = {p[0], 0.51, p[1] - 0.45};
  }
  const auto found = find_overlaps(surface, x, all_of(1));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].body, found[0].other);
  EXPECT_EQ(found[0].depth, 0.0);
  EXPECT_EQ(found[0].num_places, 1);
}

}  // namespace
}  // namespace pliant::test_overlaps
