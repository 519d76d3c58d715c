// One orientation for neighbouring triangles.
#include "base/orientation.hpp"

#include <gtest/gtest.h>

namespace pliant::test_orientation {
namespace {

using Triangles = std::vector<std::array<int, 3>>;

/// Whether each edge of two triangles is passed once in each direction.
bool is_consistent(const Triangles& triangles) {
  std::map<std::pair<int, int>, int> passed;
  for (const auto& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++passed[{triangle[k], triangle[(k + 1) % 3]}];
  }
  return std::ranges::all_of(passed, [](const auto& edge) { return edge.second == 1; });
}

TEST(Orientation, ATetrahedronIsClosedAndItsFirstTriangleStays) {
  for (int turned = 0; turned < 16; ++turned) {
    Triangles triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    for (std::size_t t = 0; t < 4; ++t) {
      if ((turned >> t) % 2 == 1) std::swap(triangles[t][1], triangles[t][2]);
    }
    const auto first = triangles[0];
    const auto parts = orient(triangles);
    ASSERT_EQ(parts.size(), 1U);
    EXPECT_TRUE(parts[0].is_closed);
    EXPECT_EQ(parts[0].triangles.size(), 4U);
    EXPECT_EQ(triangles[0], first);
    EXPECT_TRUE(is_consistent(triangles)) << turned;
  }
}

TEST(Orientation, PartsThatShareNoEdgeAreApart) {
  Triangles triangles{{0, 1, 2}, {5, 6, 7}, {1, 2, 3}, {2, 8, 9}};  // the last one shares a corner
  const auto parts = orient(triangles);
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[0].triangles, (std::vector<std::size_t>{0, 2}));
  for (const OrientedPart& part : parts) EXPECT_FALSE(part.is_closed);
  EXPECT_TRUE(is_consistent(triangles));
}

TEST(Orientation, EdgesOfThreeTrianglesSeparateParts) {
  Triangles triangles{{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  const Triangles before = triangles;
  EXPECT_EQ(orient(triangles).size(), 3U);
  EXPECT_EQ(triangles, before);
}

TEST(Orientation, AMoebiusStripHasNone) {
  Triangles triangles{{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4, 0}, {4, 0, 1}};
  const auto parts = orient(triangles);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].triangles.size(), 5U);
  EXPECT_FALSE(is_consistent(triangles));
}

}  // namespace
}  // namespace pliant::test_orientation
