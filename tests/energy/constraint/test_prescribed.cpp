// Prescribed displacements: how exact their rates are, who wins where parts overlap, what the time layer is told.
#include "energy/constraint/prescribed.hpp"
#include "energy/contact/obstacle.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"

#include <cmath>

namespace pliant::test_prescribed {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr Point origin{0.0, 0.0, 0.0};

Kinematics at(const std::string& formula, double time, double time_scale, Side side = Side::before) {
  const GivenDisplacement given{{Expression(formula), std::nullopt, std::nullopt}};
  return GivenKinematics(given, time, time_scale, 1.0, side)(0, origin);
}

TEST(Kinematics, OfPolynomialsAreExact) {
  for (const double t : {0.0, 0.05, 0.1, 2.0}) {
    const double scale = 0.1;
    const auto k = at("1 + 2*t - 3*t^2 + 0.5*t^3 - t^5", t, scale);
    EXPECT_DOUBLE_EQ(k.u, 1.0 + 2.0 * t - 3.0 * t * t + 0.5 * t * t * t - std::pow(t, 5));
    const double size = 1.0 + std::pow(t, 5);
    EXPECT_NEAR(k.v, 2.0 - 6.0 * t + 1.5 * t * t - 5.0 * std::pow(t, 4), 1e-12 * size);
    EXPECT_NEAR(k.a, -6.0 + 3.0 * t - 20.0 * std::pow(t, 3), 1e-12 * size);
  }
}

// Whatever the step: rates are those of the formula.
TEST(Kinematics, OfVibrationsAreExact) {
  for (const double scale : {1e-6, 0.05, 10.0}) {
    for (const double t : {0.0, 0.3, 1.7}) {
      const auto sine = at("sin(3*t)", t, scale);
      EXPECT_NEAR(sine.v, 3.0 * std::cos(3.0 * t), 1e-15);
      EXPECT_NEAR(sine.a, -9.0 * std::sin(3.0 * t), 1e-14);
      const auto cosine = at("1-cos(3*t)", t, scale);
      EXPECT_NEAR(cosine.v, 3.0 * std::sin(3.0 * t), 1e-15);
      EXPECT_NEAR(cosine.a, 9.0 * std::cos(3.0 * t), 1e-14);
    }
  }
}

// Where a formula has no finite rate, that over the step stands for it.
TEST(Kinematics, WithoutARateAreDifferences) {
  const double scale = 0.1;
  const auto root = at("sqrt(t)", 0.0, scale);
  EXPECT_EQ(root.u, 0.0);
  EXPECT_GT(root.v, 1.0 / std::sqrt(scale));
  EXPECT_LT(root.v, 10.0 / std::sqrt(scale));
  EXPECT_TRUE(std::isfinite(root.a));
}

// Rates are those of the side of t that the step is on, at the start of the run those after it.
TEST(Kinematics, DoNotLookAcrossAKinkAtTheStepsStartNorBeforeTheRuns) {
  const std::string ramp = "t < 1 ? 2*t : 2";
  EXPECT_NEAR(at(ramp, 1.0, 0.1).v, 2.0, 1e-12);  // the step that ends at the kink
  EXPECT_EQ(at(ramp, 1.1, 0.1).v, 0.0);           // the one that starts there
  EXPECT_EQ(at(ramp, 1.1, 1.0).v, 0.0);           // even where it is not known that there is one
  EXPECT_EQ(at(ramp, 1.0, 0.1, Side::after).v, 0.0);
  EXPECT_NEAR(at(ramp, 1.1, 0.1).a, 0.0, 1e-9);
  const std::string from_rest = "t < 0 ? 1000 : 3*t";
  EXPECT_NEAR(at(from_rest, 0.0, 0.1).v, 3.0, 1e-12);
  EXPECT_NEAR(at(from_rest, 0.03, 0.1).v, 3.0, 1e-12);
}

TEST(Kinematics, OfConstantsAreZero) {
  const GivenDisplacement given{{Expression("2*x"), std::nullopt, std::nullopt}};
  const auto k = GivenKinematics(given, 0.7, 0.1)(0, {3.0, 0.0, 0.0});
  EXPECT_EQ(k.u, 6.0);
  EXPECT_EQ(k.v, 0.0);
  EXPECT_EQ(k.a, 0.0);
}

// A body that turns about an axis which itself moves: rates by the formulas of rigid motion.
TEST(Kinematics, OfARigidBodyAreThoseOfItsMotion) {
  const Point centre{0.2, -0.1, 0.3}, X{1.0, 0.5, -0.4};
  const GivenDisplacement given{
      {},
      RigidMotion{
          {Expression("0.1*t"), std::nullopt, Expression("0.2*t^2")}, {0.6, 0.0, 0.8}, Expression("3*t"), centre}};
  EXPECT_TRUE(given.gives(0));
  EXPECT_FALSE(given.gives(1));
  const double t = 0.7;
  const GivenKinematics kinematics(given, t, 0.01);
  const Point omega{1.8, 0.0, 2.4}, arm = turn(Point{1.8 * t, 0.0, 2.4 * t}, X - centre);
  const Point v = Point{0.1, 0.0, 0.4 * t} + cross(omega, arm),
              a = Point{0.0, 0.0, 0.4} + cross(omega, cross(omega, arm));
  const Point u = Point{0.1 * t, 0.0, 0.2 * t * t} + (arm - (X - centre));
  for (int i = 0; i < 3; ++i) {
    const auto k = kinematics(i, X);
    EXPECT_NEAR(k.u, u[i], 1e-15);
    EXPECT_NEAR(given(i, X, t), k.u, 1e-15);
    EXPECT_NEAR(k.v, v[i], 1e-14);
    EXPECT_NEAR(k.a, a[i], 1e-13);
  }
}

// Friction and damping see the obstacle's velocity: exact, and behind a kink that of what follows.
TEST(Kinematics, OfAnObstacleAreExact) {
  const RigidMotion motion{{Expression("0.2*sin(40*t)"), Expression(0.0), Expression("0.3*min(t, 0.5)")},
                           {0.0, 0.0, 1.0},
                           Expression("3*t^2"),
                           {0.0, 0.0, 0.0}};
  const Obstacle obstacle(make_distance(SphereShape{{0.0, 0.0, 0.0}, 1.0}), motion);
  for (const double t : {0.25, 0.5, 0.75}) {
    const ObstacleFrame frame = obstacle.at({t, 1.0}, 0.1);
    const Point centre{0.2 * std::sin(40.0 * t), 0.0, 0.3 * std::min(t, 0.5)}, arm{0.3, -0.4, 0.1};
    const Point velocity = frame.velocity(centre + arm);
    EXPECT_NEAR(velocity[0], 8.0 * std::cos(40.0 * t) + 6.0 * t * 0.4, 1e-13);
    EXPECT_NEAR(velocity[1], 6.0 * t * 0.3, 1e-13);
    EXPECT_EQ(velocity[2], t <= 0.5 ? 0.3 : 0.0);
  }
}

// A turn by 1e-9 moves by 1e-9 of the arm, to all digits.
TEST(Placement, SmallRotationsKeepTheirDigits) {
  const Placement placement{{}, exponential({0.0, 0.0, 1e-9})};
  const auto u = placement.displacement({0.7, 0.0, 0.2});
  EXPECT_NEAR(u[1], 0.7e-9, 1e-24);
  EXPECT_NEAR(u[0], -0.35e-18, 1e-32);
}

class Prescribed : public ::testing::Test {
 protected:
  std::vector<PetscInt> nodes(const Region& region) const { return nodes_in_region(solid_.layout(), region); }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 3});
  });
  Solid solid_{comm, file_, 1, 1};
  Region left_ = [](const Point& x) { return x[0] < 1e-9; };
  Region bottom_ = [](const Point& x) { return x[2] < 1e-9; };
};

TEST_F(Prescribed, FlagsAreTheSameOnGhosts) {
  const PrescribedDisplacement motion(solid_.layout(),
                                      {{nodes(left_), {Expression(0.0), std::nullopt, Expression("t")}}}, 0.1);
  ASSERT_EQ(motion.flags().size(), 3 * static_cast<std::size_t>(solid_.layout().num_local_nodes));
  for (PetscInt a = 0; a < solid_.layout().num_local_nodes; ++a) {
    const bool on_it = left_(solid_.layout().position(a));
    EXPECT_EQ(motion.flags()[3 * a] != 0, on_it);
    EXPECT_EQ(motion.flags()[3 * a + 1], 0);
    EXPECT_EQ(motion.flags()[3 * a + 2] != 0, on_it);
  }
}

TEST_F(Prescribed, TheFirstPartCountsAndConflictsAreTold) {
  const std::array<std::optional<Expression>, 3> fixed{Expression(0.0), Expression(0.0), std::nullopt};
  const std::array<std::optional<Expression>, 3> pulled{Expression("t"), Expression("0*t"), Expression(1.0)};
  const PrescribedDisplacement motion(solid_.layout(), {{nodes(left_), fixed}, {nodes(bottom_), pulled}}, 0.1);
  const auto none = motion.conflicts(solid_.layout(), {0.0});
  EXPECT_TRUE(none.empty());  // both are 0 there at t = 0
  const auto some = motion.conflicts(solid_.layout(), {0.0, 1.0});
  EXPECT_TRUE(any_rank(comm, !some.empty()));
  for (const auto& pair : some) EXPECT_EQ(pair, std::pair(std::size_t{0}, std::size_t{1}));

  const Handle<Vec> q = solid_.vector(test::at_rest), v = solid_.vector(test::at_rest);
  motion.motion().complete_step({1.0, 0.1}, q.get(), v.get());
  const ConstArrayView u(q.get());
  for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a) {
    const Point x = solid_.layout().position(a);
    EXPECT_EQ(u[3 * a], !left_(x) && bottom_(x) ? 1.0 : 0.0);
    EXPECT_EQ(u[3 * a + 2], bottom_(x) ? 1.0 : 0.0);
  }
}

// v = (q - q0) / dt and a = (v - v0) / dt are those of the formula, which is what the stage is promised.
TEST_F(Prescribed, StageLocalDifferencesAreExact) {
  const double t = 0.6, dt = 0.1;
  const PrescribedDisplacement prescribed(
      solid_.layout(), {{nodes(left_), {Expression("(1+y)*(t^2+t)"), std::nullopt, std::nullopt}}}, dt);
  TestStage stage(solid_, t, dt, test::rough_field(1.0, 1), test::rough_field(1.0, 2));
  const auto q = solid_.vector(test::rough_field(1.0, 3));
  prescribed.motion().start_stage(stage.point, q.get());
  const ConstArrayView at_end(q.get()), q0(stage.q0.get()), v0(stage.v0.get());
  for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a) {
    const Point x = solid_.layout().position(a);
    if (!left_(x)) {
      EXPECT_NEAR(at_end[3 * a], test::rough(x, 0, 3), 1e-13);
      EXPECT_NEAR(q0[3 * a], test::rough(x, 0, 1), 1e-13);
      EXPECT_NEAR(v0[3 * a], test::rough(x, 0, 2), 1e-13);
      continue;
    }
    const double v = (at_end[3 * a] - q0[3 * a]) / dt;
    EXPECT_NEAR(at_end[3 * a], (1.0 + x[1]) * (t * t + t), 1e-14);
    EXPECT_NEAR(v, (1.0 + x[1]) * (2.0 * t + 1.0), 1e-11);
    EXPECT_NEAR((v - v0[3 * a]) / dt, (1.0 + x[1]) * 2.0, 1e-9);
  }
}

// Inside a step the differences are taken over the part of it that has passed: a kink at its start is not seen.
TEST_F(Prescribed, AStageInsideAStepDoesNotSeeTheStepBefore) {
  const double start = 1.0, step = 0.1;
  const PrescribedDisplacement prescribed(
      solid_.layout(), {{nodes(left_), {Expression("t < 1 ? 2*t : 2"), std::nullopt, std::nullopt}}}, step);
  for (const double fraction : {0.25, 0.2928932188134524, 0.5, 1.0}) {
    TestStage stage(solid_, start + fraction * step, 0.8 * step);  // as the second stage of dirk23, longer than that
    stage.point.step_start = start;
    const auto q = solid_.vector(test::at_rest);
    prescribed.motion().start_stage(stage.point, q.get());
    const ConstArrayView q0(stage.q0.get()), v0(stage.v0.get());
    for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a) {
      if (!left_(solid_.layout().position(a))) continue;
      EXPECT_NEAR(q0[3 * a], 2.0, 1e-12) << fraction;
      EXPECT_NEAR(v0[3 * a], 0.0, 1e-9) << fraction;
    }
  }
}

TEST_F(Prescribed, LoadFactorScalesTheMotion) {
  const PrescribedDisplacement prescribed(solid_.layout(),
                                          {{nodes(left_), {Expression("3*t"), std::nullopt, std::nullopt}}}, 0.1);
  TestStage stage(solid_, 2.0, 0.1);
  stage.point.load_factor = 0.25;
  const auto q = solid_.vector(test::at_rest);
  prescribed.motion().start_stage(stage.point, q.get());
  const ConstArrayView u(q.get());
  for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a) {
    EXPECT_EQ(u[3 * a], left_(solid_.layout().position(a)) ? 1.5 : 0.0);
  }
}

}  // namespace
}  // namespace pliant::test_prescribed
