// Laws of contact at a point: each force is the derivative of its potential, smooth where branches meet, and of the
// right sign.
#include "material/contact_law.hpp"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_contact_law {
namespace {

constexpr double stiffness = 3.0e4, width = 0.02, threshold = 0.05;

class NormalLaws : public ::testing::TestWithParam<NormalKind> {
 protected:
  NormalLaw law_{GetParam(), stiffness, width, threshold};
};

INSTANTIATE_TEST_SUITE_P(EveryKind, NormalLaws,
                         ::testing::Values(NormalKind::penalty, NormalKind::barrier, NormalKind::edge_barrier),
                         [](const auto& of) {
                           if (of.param == NormalKind::penalty) return "Penalty";
                           return of.param == NormalKind::barrier ? "Barrier" : "EdgeBarrier";
                         });

// Fourth-order differences over a 2000th of the width: errors and rounding of 1e-10 of the values.
TEST_P(NormalLaws, PressureIsTheSlopeOfTheEnergyAndStiffnessThatOfThePressure) {
  const double h = width / 2000.0;
  const auto slope = [&](auto of, double d) {
    return (8.0 * (of(law_(d + h)) - of(law_(d - h))) - (of(law_(d + 2.0 * h)) - of(law_(d - 2.0 * h)))) / (12.0 * h);
  };
  for (int k = 0; k < 100; ++k) {
    const double start = GetParam() == NormalKind::penalty ? -3.0 : GetParam() == NormalKind::barrier ? 0.05 : 0.1;
    const double d = threshold + width * (start + (1.2 - start) * k / 100.0);
    const NormalResponse at = law_(d);
    EXPECT_NEAR(slope([](const auto& r) { return r.energy; }, d), -at.pressure, 1e-6 * stiffness * width);
    EXPECT_NEAR(slope([](const auto& r) { return r.pressure; }, d), -at.stiffness, 1e-5 * (stiffness + at.stiffness));
    EXPECT_GE(at.energy, 0.0);
    EXPECT_GE(at.pressure, 0.0);
    EXPECT_GE(at.stiffness, 0.0);
  }
}

TEST_P(NormalLaws, NothingIsFeltOutOfReach) {
  EXPECT_DOUBLE_EQ(law_.reach(), GetParam() == NormalKind::penalty ? threshold : threshold + width);
  EXPECT_EQ(law_(law_.reach()).pressure, 0.0);
  EXPECT_GT(law_(law_.reach() - 1e-3 * width).pressure, 0.0);
}

TEST(NormalLaw, PenaltyIsASpringWithARoundedKink) {
  const NormalLaw law{NormalKind::penalty, stiffness, width, threshold};
  for (const double depth : {1.0, 2.5}) {
    const NormalResponse at = law(threshold - (depth + 1.0) * width);
    EXPECT_NEAR(at.pressure, stiffness * depth * width, 1e-12 * stiffness * width);
    EXPECT_DOUBLE_EQ(at.stiffness, stiffness);
  }
  // U, p and U'' are the same from both sides of both joints, and so is the slope of U''.
  for (const double joint : {-1.0, 1.0}) {
    const double d = threshold - (joint + 1.0) * width, e = 1e-6 * width;
    const NormalResponse before = law(d - e), after = law(d + e);
    EXPECT_NEAR(before.energy, after.energy, 1e-5 * stiffness * width * width);
    EXPECT_NEAR(before.pressure, after.pressure, 1e-5 * stiffness * width);
    EXPECT_NEAR(before.stiffness, after.stiffness, 1e-10 * stiffness);  // its slope is zero there
  }
}

TEST(NormalLaw, BarriersHaveNoOtherSide) {
  const NormalLaw law{NormalKind::barrier, stiffness, width, threshold};
  const NormalLaw of_edges{NormalKind::edge_barrier, stiffness, width, threshold};
  for (const double d : {threshold, threshold - width, -1.0}) {
    EXPECT_EQ(law(d).energy, std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(law(d).pressure));
    EXPECT_EQ(of_edges(d).energy, std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(of_edges(d).pressure));
  }
  EXPECT_GT(law(threshold + 1e-6 * width).pressure, 1e5 * stiffness * width);
  EXPECT_GT(of_edges(threshold + 0.03 * width).pressure, 1e3 * stiffness * width);
  const double begin = threshold + (1.0 - 1e-4) * width;
  EXPECT_NEAR(of_edges(begin).pressure, law(begin).pressure, 1e-3 * law(begin).pressure);
}

/// Velocities of all sizes, in all directions.
std::vector<Vector3<double>> velocities(double size) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Vector3<double>> result;
  for (int k = 0; k < 200; ++k) {
    const double s = size * std::pow(10.0, -1.5 + 2.5 * k / 200.0);
    result.push_back({s * normal(random), s * normal(random), s * normal(random)});
  }
  return result;
}

constexpr double pressure = 700.0, speed = 0.3;
const Vector3<double> n{2.0 / 7, -3.0 / 7, 6.0 / 7};

template <class Drag>
void expect_derivatives(const Drag& drag) {
  for (const auto& v : velocities(speed)) {
    const DragResponse at = drag(pressure, n, v);
    const double h = 1e-5 * std::sqrt(dot(v, v)), size = std::sqrt(dot(at.slope, at.slope));
    for (std::size_t i = 0; i < 3; ++i) {
      auto ahead = v, behind = v;
      ahead[i] += h;
      behind[i] -= h;
      const DragResponse a = drag(pressure, n, ahead), b = drag(pressure, n, behind);
      EXPECT_NEAR((a.potential - b.potential) / (2.0 * h), at.slope[i], 1e-6 * size);
      for (std::size_t j = 0; j < 3; ++j) {
        const double entry = at.hessian(static_cast<int>(j), static_cast<int>(i));
        EXPECT_NEAR((a.slope[j] - b.slope[j]) / (2.0 * h), entry, 1e-4 * size / speed + 1e-4 * std::abs(entry));
      }
    }
    EXPECT_GE(dot(at.slope, v), 0.0) << "a drag takes energy";
    for (const auto& w : {Vector3<double>{1.0, 0.0, 0.0}, {0.3, -0.5, 0.8}, v}) {
      EXPECT_GE(dot(w, matvec(at.hessian, w)), -1e-12 * dot(w, w) * trace(at.hessian)) << "R is convex";
    }
  }
}

TEST(Friction, ForceIsTheSlopeOfAConvexPotential) {
  expect_derivatives(Friction{0.4, 0.0, speed});
  expect_derivatives(Friction{0.4, 0.7, speed});
  expect_derivatives(Friction{0.0, 0.7, speed});
}

TEST(Friction, IsCoulombsAboveTheStickVelocityAndSmoothBelow) {
  const Friction friction{0.4, 0.0, speed};
  const Vector3<double> along{3.0 / 7, 6.0 / 7, 2.0 / 7};  // across n
  for (const double s : {1.0, 1.5, 100.0}) {
    const auto force = friction(pressure, n, (s * speed) * along).slope;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(force[i], 0.4 * pressure * along[i], 1e-10);
  }
  double last = 0.0;
  for (int k = 1; k < 100; ++k) {
    const auto at = friction(pressure, n, (0.01 * k * speed) * along + 5.0 * n);
    const double force = dot(at.slope, along);
    EXPECT_GT(force, last) << "it grows up to the stick velocity";
    EXPECT_LT(force, 0.4 * pressure);
    EXPECT_NEAR(dot(at.slope, n), 0.0, 1e-11) << "what goes along the normal does not count";
    last = force;
  }
  // Both branches meet with the same potential, force and tangent.
  const auto before = friction(pressure, n, ((1.0 - 1e-9) * speed) * along),
             after = friction(pressure, n, ((1.0 + 1e-9) * speed) * along);
  EXPECT_NEAR(before.potential, after.potential, 1e-6);
  EXPECT_NEAR(trace(before.hessian), trace(after.hessian), 1e-5 * trace(after.hessian));
}

TEST(NormalDamping, ForceIsTheSlopeOfAConvexPotential) {
  expect_derivatives(NormalDamping{2.0});
}

TEST(NormalDamping, AddsToThePressureAsTheBodyApproachesAndNeverPulls) {
  const NormalDamping damping{2.0};
  EXPECT_NEAR(-dot(damping(pressure, n, -0.1 * n).slope, n), 0.2 * pressure, 1e-10);
  EXPECT_NEAR(-dot(damping(pressure, n, 0.1 * n).slope, n), -0.2 * pressure, 1e-10);
  for (const double away : {0.3, 1.0, 100.0}) {
    EXPECT_GT(-dot(damping(pressure, n, away * n).slope, n), -pressure);
  }
}

}  // namespace
}  // namespace pliant::test_contact_law
