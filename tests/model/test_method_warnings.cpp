#include "model/method_warnings.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant {
namespace {

double per_square_of_angle(const char* method) {
  constexpr double angle = 1e-2;
  return stretch_of_rotation(*find_method(method), angle) / (angle * angle);
}

// The chord: half a step on, the midpoint rule has turned by half the angle; it goes on as far again along the tangent.
TEST(MethodWarnings, StretchOfARotation) {
  EXPECT_NEAR(per_square_of_angle("implicit-midpoint"), 1.0 / 4.0, 1e-4);
  EXPECT_NEAR(per_square_of_angle("symplectic-dirk22"), 1.0 / 16.0, 1e-4);
  EXPECT_NEAR(per_square_of_angle("dirk23"), 0.144, 1e-3);
}

TEST(MethodWarnings, MethodsThatEndInAStageDoNotStretch) {
  for (const Method& method : methods()) {
    if (method.num_steps == 1 && method.stiffly_accurate) {
      EXPECT_NEAR(stretch_of_rotation(method, 0.1), 0.0, 1e-14) << method.name;
    }
  }
}

// bdf3: 1 + (omega dt)^4 / 4 for slow vibrations, at most 4.6 % at 1.14 (docs/methods.md).
TEST(MethodWarnings, GrowthOfVibrations) {
  const Method& bdf3 = *find_method("bdf3");
  const FastestGrowth slow = fastest_growth(bdf3, 1e-3, 0.1);
  EXPECT_NEAR((slow.factor - 1.0) / (std::pow(0.1, 4) / 4.0), 1.0, 0.05);
  const FastestGrowth any = fastest_growth(bdf3, 1e-3, 1e3);
  EXPECT_NEAR(any.factor, 1.046, 1e-3);
  EXPECT_NEAR(any.phase, 1.14, 0.05);
  EXPECT_DOUBLE_EQ(fastest_growth(bdf3, 2.0, 100.0).factor, 1.0);
  for (const Method& method : methods()) {
    if (method.stability != Stability::not_a_stable) {
      EXPECT_LT(fastest_growth(method, 1e-3, 1e3).factor, 1.0 + 1e-9) << method.name;
    }
  }
}

}  // namespace
}  // namespace pliant
