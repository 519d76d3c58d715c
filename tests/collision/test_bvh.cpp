#include "collision/bvh.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>

namespace pliant::test_bvh {
namespace {

using testing_collision::RandomPoints;

/// Boxes of several sizes; every fourth at one of a few places, so that codes are equal.
std::vector<Box> random_boxes(std::size_t number, unsigned seed, double size) {
  RandomPoints random(seed);
  std::vector<Box> boxes(number);
  for (std::size_t n = 0; n < number; ++n) {
    Vector3<double> centre = random.point();
    if (n % 4 == 0) centre = {std::round(centre[0]), std::round(centre[1]), std::round(centre[2])};
    const auto extent = random.point(n % 50 == 0 ? 20.0 * size : size);
    boxes[n] = box_of(0.0, centre - extent, centre + extent);
  }
  return boxes;
}

std::vector<BoxPair> brute_force(std::span<const Box> a, std::span<const Box> b) {
  std::vector<BoxPair> pairs;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(a.size()); ++i) {
    for (std::int32_t j = 0; j < static_cast<std::int32_t>(b.size()); ++j) {
      if (a[i].overlaps(b[j])) pairs.push_back({i, j});
    }
  }
  return pairs;
}
std::vector<BoxPair> brute_force(std::span<const Box> boxes) {
  std::vector<BoxPair> pairs = brute_force(boxes, boxes);
  std::erase_if(pairs, [](const BoxPair& pair) { return pair.first >= pair.second; });
  return pairs;
}

const auto all = [](std::int32_t, std::int32_t) { return true; };

class BvhOfSize : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Sizes, BvhOfSize, testing::Values(0, 1, 2, 7, 8, 9, 63, 64, 65, 511, 512, 513, 2000));

TEST_P(BvhOfSize, FindsThePairsOfBruteForce) {
  const auto boxes = random_boxes(GetParam(), 1, 0.05);
  const auto pairs = overlapping_pairs(Bvh(boxes), all);
  EXPECT_EQ(pairs, brute_force(boxes));
  if (GetParam() >= 64) {
    EXPECT_GT(pairs.size(), GetParam() / 10);
  }
}

TEST_P(BvhOfSize, FindsThePairsOfTwoSets) {
  const auto boxes = random_boxes(GetParam(), 2, 0.05), others = random_boxes(500, 3, 0.05);
  EXPECT_EQ(overlapping_pairs(Bvh(boxes), Bvh(others), all), brute_force(boxes, others));
  EXPECT_EQ(overlapping_pairs(Bvh(others), Bvh(boxes), all), brute_force(others, boxes));
}

TEST_P(BvhOfSize, FindsThePairsAfterARefit) {
  auto boxes = random_boxes(GetParam(), 4, 0.05);
  Bvh tree(boxes);
  boxes = random_boxes(GetParam(), 5, 0.05);  // all elsewhere
  tree.refit(boxes);
  EXPECT_EQ(overlapping_pairs(tree, all), brute_force(boxes));
}

TEST_P(BvhOfSize, FindsTheBoxesThatOverlapOne) {
  const auto boxes = random_boxes(GetParam(), 8, 0.05), others = random_boxes(50, 9, 0.2);
  const Bvh tree(boxes);
  for (const Box& other : others) {
    std::vector<std::int32_t> found, expected;
    tree.for_each_overlap(other, [&](std::int32_t n) { found.push_back(n); });
    std::ranges::sort(found);
    for (std::int32_t n = 0; n < static_cast<std::int32_t>(boxes.size()); ++n) {
      if (boxes[n].overlaps(other)) expected.push_back(n);
    }
    EXPECT_EQ(found, expected);
  }
}

// Every box lies within one of the few, and these within the whole.
TEST_P(BvhOfSize, IsCoveredByFewBoxes) {
  const auto boxes = random_boxes(GetParam(), 10, 0.05);
  Box whole;
  for (const Box& box : boxes) whole.include(box);
  const auto holds = [](const Box& outer, const Box& inner) {
    Box both = outer;
    both.include(inner);
    return both.low == outer.low && both.high == outer.high;
  };
  for (const std::size_t at_most : {8U, 64U, 100U}) {
    const auto few = Bvh(boxes).cover(at_most);
    EXPECT_LE(few.size(), at_most);
    EXPECT_GE(8 * few.size(), std::min(at_most, boxes.size()));
    for (const Box& box : boxes) {
      EXPECT_TRUE(std::ranges::any_of(few, [&](const Box& outer) { return holds(outer, box); }));
    }
    for (const Box& outer : few) EXPECT_TRUE(holds(whole, outer));
  }
}

// Coordinates beyond the floats make boxes without bounds, which overlap all, but nothing that is not there.
TEST(Bvh, TakesBoxesBeyondTheRangeOfFloats) {
  auto boxes = random_boxes(20, 11, 0.01);
  boxes[7] = box_of(0.0, {-1e300, -1e300, -1e300}, Vector3<double>{1e300, 1e300, 1e300});
  EXPECT_EQ(overlapping_pairs(Bvh(boxes), all), brute_force(boxes));
  EXPECT_EQ(overlapping_pairs(Bvh(boxes), Bvh(boxes), all), brute_force(boxes, boxes));
}

TEST(Bvh, TakesOnlyPairsThatAreAccepted) {
  const auto boxes = random_boxes(300, 6, 0.2);
  const auto accept = [](std::int32_t i, std::int32_t j) { return (i + j) % 3 == 0; };
  auto expected = brute_force(boxes);
  const std::size_t before = expected.size();
  std::erase_if(expected, [&](const BoxPair& pair) { return !accept(pair.first, pair.second); });
  ASSERT_LT(expected.size(), before);
  EXPECT_EQ(overlapping_pairs(Bvh(boxes), accept), expected);
}

TEST(Bvh, FindsAllBoxesAtOnePlace) {
  const std::vector<Box> boxes(100, box_of(0.0, {1, 2, 3}));
  EXPECT_EQ(overlapping_pairs(Bvh(boxes), all).size(), 4950U);
}

TEST(Box, IsRoundedOutwards) {
  RandomPoints random(7);
  for (int trial = 0; trial < 10000; ++trial) {
    const double x = random.number(-1.0, 1.0) * std::pow(10.0, random.number(-45.0, 45.0));
    const float low = rounded_down(x), high = rounded_up(x);
    EXPECT_LE(static_cast<double>(low), x);
    EXPECT_GE(static_cast<double>(high), x);
    if (std::abs(x) > 1e-30 && std::abs(x) < 1e30) {
      EXPECT_LT((double{high} - low) / std::abs(x), 6e-7);
    }
  }
  EXPECT_LT(rounded_down(0.0), 0.0F);
  EXPECT_GT(rounded_up(0.0), 0.0F);
  EXPECT_LT(static_cast<double>(rounded_down(1e300)), 1e300);
  EXPECT_TRUE(std::isinf(rounded_up(1e300)));
}

TEST(Box, OfPointsHoldsThemWithAMargin) {
  const Box box = box_of(0.5, {0, 0, 0}, Vector3<double>{1, -1, 2});
  EXPECT_NEAR(box.low[1], -1.5, 1e-6);
  EXPECT_NEAR(box.high[2], 2.5, 1e-6);
  EXPECT_TRUE(box.overlaps(box_of(0.0, {1.5, 0, 0})));
  EXPECT_FALSE(box.overlaps(box_of(0.0, {1.51, 0, 0})));
  EXPECT_FALSE(box.overlaps(Box{}));
  EXPECT_TRUE(box.contains({1.4, 0.0, 0.0}));
  EXPECT_FALSE(box.contains({1.6, 0.0, 0.0}));
  EXPECT_FALSE(box.contains({std::nan(""), 0.0, 0.0}));
}

TEST(Box, GrowsOutwards) {
  const Box box = box_of(0.0, {0, 0, 0}, Vector3<double>{1e300, 1, 1}).grown(0.25);
  EXPECT_LE(double{box.low[0]}, -0.25);
  EXPECT_NEAR(box.low[0], -0.25, 1e-6);
  EXPECT_TRUE(std::isinf(box.high[0]));
  EXPECT_GE(double{box.high[1]}, 1.25);
  EXPECT_FALSE(box.overlaps(Box{}.grown(1.0)));
}

}  // namespace
}  // namespace pliant::test_bvh
