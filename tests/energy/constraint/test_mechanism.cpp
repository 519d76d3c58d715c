// The equations of joints, and what a mechanism makes of them.
#include "energy/constraint/mechanism.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"
#include "time/stage.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace pliant::test_mechanism {
namespace {

using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr int ground = JointEquation::ground;

Vector3<double> unit_vector(std::size_t i) {
  Vector3<double> e{};
  e[i] = 1.0;
  return e;
}

/// One equation of each kind, between a first and a second body.
std::vector<JointEquation> one_of_each() {
  return {{Coincidence{{0.3, 0.2, 0.1}, {0.6, 0.0, 0.8}}, {0, 1}, 0},
          {Perpendicularity{{0.0, 0.6, 0.8}, {1.0, 0.0, 0.0}}, {0, 1}, 0},
          {Travel{{0.3, 0.2, 0.1}, {0.6, 0.0, 0.8}, std::nullopt}, {0, 1}, 0},
          {Travel{{0.3, 0.2, 0.1}, {0.6, 0.0, 0.8}, Expression("0.1*t^2")}, {0, 1}, 0},
          {Turn{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, Expression("sin(3*t)")}, {0, 1}, 0},
          {Distance{{0.3, 0.2, 0.1}, {0.9, 0.1, 0.4}, 0.7, std::nullopt}, {0, 1}, 0},
          {Distance{{0.3, 0.2, 0.1}, {0.9, 0.1, 0.4}, 0.7, Expression("0.1*t^3")}, {0, 1}, 0}};
}

/// A motion with all of its numbers smooth functions of time.
BodyMotion<double> motion(double t, double phase) {
  BodyMotion<double> result{{0.1, 0.2, phase}, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = 0.1 * std::sin(2.0 * t + phase + static_cast<double>(i));
  for (std::size_t i = 0; i < 9; ++i)
    result.gradient.a[i] = 0.2 * std::cos(t * (1.0 + 0.1 * static_cast<double>(i)) + phase);
  return result;
}

BodyMotion<TimeSeries<double>> series(double t, double phase) {
  BodyMotion<TimeSeries<double>> result{motion(t, phase).centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = 2.0 * t + phase + static_cast<double>(i);
    result.translation[i] = {0.1 * std::sin(x), 0.2 * std::cos(x), -0.4 * std::sin(x)};
  }
  for (std::size_t i = 0; i < 9; ++i) {
    const double w = 1.0 + 0.1 * static_cast<double>(i), x = w * t + phase;
    result.gradient.a[i] = {0.2 * std::cos(x), -0.2 * w * std::sin(x), -0.2 * w * w * std::cos(x)};
  }
  return result;
}

TEST(JointEquations, RatesAreThoseOfTheValue) {
  const double t = 0.4, h = 1e-3;
  for (const JointEquation& equation : one_of_each()) {
    const auto given_at = [&](double time) {
      if (equation.given() == nullptr) return TimeSeries<double>{};
      const TimeJet jet = equation.given()->derivatives(0.0, 0.0, 0.0, time, time);
      return TimeSeries<double>{jet.value, jet.rate, jet.acceleration};
    };
    const auto value = [&](double time) { return equation(motion(time, 0.3), motion(time, 1.1), given_at(time)); };
    const auto found = equation(series(t, 0.3), series(t, 1.1), given_at(t));
    const double rate = (8.0 * (value(t + h) - value(t - h)) - (value(t + 2 * h) - value(t - 2 * h))) / (12.0 * h);
    const double acceleration =
        (16.0 * (value(t + h) + value(t - h)) - (value(t + 2 * h) + value(t - 2 * h)) - 30.0 * value(t)) /
        (12.0 * h * h);
    EXPECT_DOUBLE_EQ(found.value, value(t)) << equation.kind.index();
    EXPECT_NEAR(found.rate, rate, 1e-10) << equation.kind.index();
    EXPECT_NEAR(found.acceleration, acceleration, 1e-8) << equation.kind.index();
  }
}

// Forces between bodies have no resultant and no moment: equations do not change where both bodies move together.
TEST(JointEquations, DoNotSeeMotionsOfTheWhole) {
  const Vector3<double> theta = {0.3, -0.5, 0.2}, shift = {0.4, 0.1, -0.2};
  const auto moved = [&](BodyMotion<double> m) {
    const Vector3<double> centre = turn(theta, m.point(m.centre)) + shift;
    BodyMotion<double> result{m.centre, centre - m.centre, {}};
    for (std::size_t j = 0; j < 3; ++j) {
      const Vector3<double> column = turn(theta, m.direction(unit_vector(j))) - unit_vector(j);
      for (std::size_t i = 0; i < 3; ++i) result.gradient(static_cast<int>(i), static_cast<int>(j)) = column[i];
    }
    return result;
  };
  for (const JointEquation& equation : one_of_each()) {
    if (std::holds_alternative<Coincidence>(equation.kind)) continue;  // its axes are fixed: all three belong together
    const TimeSeries<double> given(0.1, 0.2, 0.3);
    EXPECT_NEAR(equation(moved(motion(0.4, 0.3)), moved(motion(0.4, 1.1)), given),
                equation(motion(0.4, 0.3), motion(0.4, 1.1), given), 1e-14);
  }
}

class Mechanisms : public ::testing::Test {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 3});
  });
  Solid solid_{comm, file_, 1, 1};

  std::unique_ptr<RigidPart> slab(bool is_first) const {
    const auto nodes =
        nodes_in_region(solid_.layout(), [=](const Point& x) { return is_first ? x[0] < 0.4 : x[0] > 0.6; });
    return std::make_unique<RigidPart>(solid_.layout(), nodes, RigidMotion{}, FreeRotation::about_all_axes);
  }
  Mechanism make(std::vector<JointEquation> equations) const {
    std::vector<std::unique_ptr<RigidPart>> parts;
    for (const bool is_first : {true, false}) parts.push_back(slab(is_first));
    return {solid_.layout(), std::move(parts), std::move(equations)};
  }
  static std::vector<JointEquation> ball(std::array<int, 2> bodies, const Point& at, std::size_t joint) {
    std::vector<JointEquation> equations;
    for (std::size_t i = 0; i < 3; ++i) equations.push_back({Coincidence{at, unit_vector(i)}, bodies, joint});
    return equations;
  }
};

TEST_F(Mechanisms, CountTheirDegreesOfFreedom) {
  auto equations = ball({ground, 0}, {0.0, 0.5, 0.5}, 0);
  for (auto& e : ball({0, 1}, {0.5, 0.5, 0.5}, 1)) equations.push_back(e);
  EXPECT_EQ(make({}).num_degrees_of_freedom(), 12u);
  EXPECT_EQ(make(equations).num_degrees_of_freedom(), 6u);
  EXPECT_TRUE(make(equations).dependent_joints().empty());
  // A line between two points of bodies that turn about their middle is no constraint of its own length alone: a third
  // ball closes a loop that cannot move, and a fourth repeats it.
  for (auto& e : ball({ground, 1}, {1.0, 0.5, 0.5}, 2)) equations.push_back(e);
  EXPECT_EQ(make(equations).dependent_joints(), (std::vector<std::size_t>{0, 1, 2}));
}

// Where a step ends, the joints' equations and their rates hold, whatever came before.
TEST_F(Mechanisms, EndStepsOnTheirJoints) {
  auto equations = ball({ground, 0}, {0.1, 0.5, 0.4}, 0);
  equations.push_back({Turn{unit_vector(0), unit_vector(1), Expression("0.3+0.5*t")}, {ground, 0}, 0});
  equations.push_back({Distance{{0.2, 0.1, 0.3}, {0.9, 0.8, 0.4}, 1.0, Expression("0.05*t")}, {0, 1}, 1});
  const auto copy = equations;
  const Mechanism mechanism = make(std::move(equations));
  const auto q = solid_.vector([](const Point& x) { return 0.1 * test::strained(x); });
  const auto v = solid_.vector(test::rough_field(0.3, 5));
  const Step step{0.7, 0.05};
  mechanism.complete_step(step, q.get(), v.get());
  const auto states = mechanism.states({0, 1}, q.get(), v.get());
  const auto series_of = [&](int body) {
    BodyMotion<TimeSeries<double>> result{};
    if (body < 0) return result;
    const auto x = states[static_cast<std::size_t>(body)].motion(),
               rate = states[static_cast<std::size_t>(body)].rate();
    result.centre = x.centre;
    for (std::size_t i = 0; i < 3; ++i) result.translation[i] = {x.translation[i], rate.translation[i], 0.0};
    for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = {x.gradient.a[i], rate.gradient.a[i], 0.0};
    return result;
  };
  for (const JointEquation& equation : copy) {
    TimeSeries<double> given;
    if (equation.given() != nullptr) {
      const TimeJet jet = equation.given()->derivatives(0.0, 0.0, 0.0, 0.7, 0.69);
      given = {jet.value, jet.rate, jet.acceleration};
    }
    const auto g = equation(series_of(equation.bodies[0]), series_of(equation.bodies[1]), given);
    EXPECT_NEAR(g.value, 0.0, 1e-13);
    EXPECT_NEAR(g.rate, 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace pliant::test_mechanism
