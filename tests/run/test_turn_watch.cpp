// Prescribed rotations that a step can follow, and those that it cannot.
#include "input/input.hpp"
#include "run/turn_watch.hpp"

#include <gtest/gtest.h>

namespace pliant::test_turn_watch {
namespace {

Config input(const std::string& angle, const std::string& time = "{method: bdf2, step: 0.1, end: 2}") {
  return read_input(
      "rigid_bodies: [{name: hub, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0]}]\n"
      "constraints: [{volume: hub, rigid: {translation: [0, 0, 0], rotation: {axis: [1, 0, 0], angle: \"" +
          angle + "\"}}}]\ntime: " + time + "\n",
      "hub.yaml", {});
}

TEST(TurnWatch, StepsPrescribeLessThanHalfATurn) {
  const Config config = input("10*t");
  const TurnWatch turns(config);
  EXPECT_FALSE(turns.too_far(0.0, 0.3));
  const auto reason = turns.too_far(0.5, 0.9);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("turns by 4 rad"), std::string::npos) << *reason;
  EXPECT_NE(reason->find("'hub'"), std::string::npos) << *reason;
}

TEST(TurnWatch, InStaticsTheAngleGrowsWithTheLoad) {
  const Config config = input("5", "{method: static, load_steps: 4}");
  const TurnWatch turns(config);
  EXPECT_FALSE(turns.too_far(0.0, 0.5));
  const auto reason = turns.too_far(0.0, 1.0);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("load_steps"), std::string::npos) << *reason;
}

// No shorter step would follow it.
TEST(TurnWatch, AJumpIsNamedInsteadOfCut) {
  const Config config = input("t < 1 ? 0 : 4");
  TurnWatch turns(config);
  EXPECT_FALSE(turns.too_far(0.9, 1.2));
  const auto within = turns.accept(0.9, 1.2);
  ASSERT_TRUE(within);
  EXPECT_NE(within->find("jumps by 4 rad at t = 1"), std::string::npos) << *within;
  EXPECT_FALSE(turns.accept(1.2, 1.5));
}

TEST(TurnWatch, AJumpBetweenStepsIsNamedUnlessTheStateIsAnother) {
  const Config config = input("t < 1 ? 0 : 4");
  TurnWatch turns(config);
  EXPECT_FALSE(turns.accept(0.5, 1.0));
  EXPECT_TRUE(turns.accept(1.0, 1.2));
  EXPECT_FALSE(turns.accept(1.2, 1.4));
  turns.forget();  // back to an earlier state
  EXPECT_FALSE(turns.accept(0.5, 0.9));
}

}  // namespace
}  // namespace pliant::test_turn_watch
