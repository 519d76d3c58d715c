// Friction of bearings from the load that they carry.
#include "energy/rigid/joint_bearing.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_joint_bearing {
namespace {

const Vector3<double> axis{0.0, 0.0, 1.0};

JointBearing hinge(std::optional<double> length) {
  return {JointAngle{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, 0.1, 0.02, length, axis, {}, {}, 0};
}

JointBearing slider(std::optional<double> radius, std::optional<double> length) {
  return {JointTravel{{}, axis}, 0.1, radius, length, axis, {}, {}, 0};
}

TEST(JointBearing, OfAHingeCarriesForcesAndThrustAtItsRadius) {
  EXPECT_NEAR(largest_friction(hinge({}), {{3.0, 4.0, 0.0}, {7.0, 7.0, 7.0}}, axis), 0.1 * 0.02 * 5.0, 1e-15);
  EXPECT_NEAR(largest_friction(hinge({}), {{3.0, 4.0, -6.0}, {}}, axis), 0.1 * 0.02 * 11.0, 1e-15);
}

// A force at a distance x along the axis from the middle: the places carry F (1/2 +- x / length).
TEST(JointBearing, CarriesCouplesAtTwoPlaces) {
  const double F = 5.0, length = 0.4;
  for (const double x : {0.0, 0.1, 0.2, 0.5}) {
    const Vector3<double> force{F, 0.0, 0.0};
    const double load = F * (std::abs(0.5 + x / length) + std::abs(0.5 - x / length));
    const JointReaction reaction{force, cross(x * axis, force)};
    EXPECT_NEAR(largest_friction(hinge(length), reaction, axis), 0.1 * 0.02 * load, 1e-15) << x;
    EXPECT_NEAR(largest_friction(slider({}, length), reaction, axis), 0.1 * load, 1e-15) << x;
  }
}

TEST(JointBearing, OfASliderCarriesTorquesAboutItsAxisAtItsRadius) {
  const JointReaction reaction{{3.0, 4.0, 9.0}, {0.0, 0.0, -0.6}};
  EXPECT_NEAR(largest_friction(slider({}, {}), reaction, axis), 0.1 * 5.0, 1e-15);
  EXPECT_NEAR(largest_friction(slider(0.2, {}), reaction, axis), 0.1 * (5.0 + 3.0), 1e-15);
}

}  // namespace
}  // namespace pliant::test_joint_bearing
