// Ways of points through solids: what enters on one side must not leave on the other.
#include "energy/contact/passage.hpp"

#include <memory>

#include <gtest/gtest.h>

namespace pliant::test_passage {
namespace {

using Point = Vector3<double>;

std::unique_ptr<SignedDistance> plate() {
  return make_distance(BoxShape{{}, {2.0, 2.0, 0.1}});
}
std::unique_ptr<SignedDistance> rod() {
  return make_distance(CapsuleShape{{}, {1.0, 0.0, 0.0}, 0.1, 2.0});
}

TEST(Passage, OfAPlateIsSeenHoweverFarTheWayGoes) {
  for (const double end : {-0.06, -0.2, -10.0}) {
    const auto found = passage(*plate(), {0.1, 0.2, 0.3}, {0.2, 0.1, end});
    ASSERT_TRUE(found) << end;
    EXPECT_GT(found->depth, 0.03);  // of 0.05, as it is seen where the way is looked at
    EXPECT_LE(found->depth, 0.05);
  }
}

TEST(Passage, BeginsAtTheMiddle) {
  EXPECT_FALSE(passage(*plate(), {0.0, 0.0, 0.2}, {0.0, 0.0, 0.02}));   // 3/10 deep
  EXPECT_TRUE(passage(*plate(), {0.0, 0.0, 0.2}, {0.0, 0.0, 0.005}));   // nearly half
  EXPECT_TRUE(passage(*plate(), {0.0, 0.0, 0.2}, {0.0, 0.0, -0.02}));   // nearer to the other side
  EXPECT_TRUE(passage(*plate(), {0.0, 0.0, 0.02}, {0.0, 0.0, -0.02}));  // from within
  EXPECT_FALSE(passage(*rod(), {0.0, 0.0, 0.2}, {0.0, 0.0, 0.06}));
  EXPECT_TRUE(passage(*rod(), {0.0, 0.0, 0.2}, {0.0, 0.0, 0.01}));
}

TEST(Passage, IsNotWhatIsPushedBackOrCutsACorner) {
  EXPECT_FALSE(passage(*plate(), {0.0, 0.0, 0.04}, {0.0, 0.0, 0.2}));
  EXPECT_FALSE(passage(*plate(), {0.0, 0.0, 0.04}, {0.9, 0.0, 0.04}));  // slides within
  EXPECT_FALSE(passage(*plate(), {0.9, 0.0, 0.06}, {1.1, 0.0, 0.03}));  // over the rim
  EXPECT_FALSE(passage(*rod(), {0.0, -0.2, 0.09}, {0.0, 0.2, 0.09}));   // over its back
  EXPECT_TRUE(passage(*rod(), {0.0, -0.2, 0.02}, {0.0, 0.2, 0.02}));
  EXPECT_FALSE(passage(*rod(), {0.0, 0.0, 0.3}, {0.0, 0.0, 0.11}));  // does not arrive
}

TEST(Passage, OfAPlaneOrAVesselDoesNotHappen) {
  const auto plane = make_distance(PlaneShape{{}, {0.0, 0.0, 1.0}});
  EXPECT_FALSE(passage(*plane, {0.0, 0.0, 0.1}, {0.0, 0.0, -5.0}));
  const auto vessel = hollow(make_distance(SphereShape{{}, 1.0}));
  EXPECT_FALSE(passage(*vessel, {0.0, 0.0, 0.9}, {0.0, 0.0, 1.5}));
}

}  // namespace
}  // namespace pliant::test_passage
