// Springs, dampers and motors of joints: derivatives, opposite forces, the same numbers on every number of ranks.
#include "energy/rigid/joint_effort.hpp"
#include "energy/two_bodies.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace pliant::test_joint_effort {
namespace {

using test::Field;
using test::Point;
using test::Solid;
using test::TwoBodies;
using test::TwoBodiesFile;

const MPI_Comm comm = MPI_COMM_WORLD;

struct EffortCase {
  std::string name;
  JointLaw law;
  JointCoordinate coordinate;
  std::array<int, 2> bodies{0, 1};
  double turns = 0.0;  ///< of the second body since the start: a multiple of a half
  JointRates rates = JointRates::derivatives;
};

constexpr double turn = 2.0 * std::numbers::pi;

std::ostream& operator<<(std::ostream& out, const EffortCase& c) {
  return out << c.name;
}

std::vector<EffortCase> every_case() {
  const JointAngle angle{{0.0, 0.6, 0.8}, {0.0, -0.8, 0.6}};
  const JointTravel travel{{1.1, 0.4, 0.6}, {0.6, 0.0, 0.8}};
  const JointMotor motor{Expression("0.3*sin(4*t)"), 20.0, 0.7, 2.0, Expression("0.5*t")};
  std::vector<EffortCase> cases{
      {"TurnedSpring", JointSpring{30.0, 0.4}, angle},
      {"Spring", JointSpring{30.0, 0.1}, travel},
      {"TurnedDamper", JointDamper{3.0}, angle},
      {"Damper", JointDamper{3.0}, travel},
      {"TurningMotor", motor, angle},
      {"Motor", motor, travel},
      {"TurnedStops", JointStops{0.05, 0.55, 40.0, 0.05}, angle},
      {"TurnedStopsWithinTheirRounding", JointStops{0.05, 0.55, 40.0, 0.5}, angle},
      {"Stops", JointStops{0.1, 0.3, 40.0, 0.02}, travel},
      {"TurningFriction", JointFriction{0.7, 0.4}, angle},
      {"Friction", JointFriction{0.7, 0.4}, travel},
      {"TurningBearing", BearingFriction{std::make_shared<double>(0.7), 0.4}, angle},
      {"SpringToGround", JointSpring{30.0, 0.1}, travel, {-1, 1}},
      {"MotorOnGround", motor, angle, {-1, 0}},
      {"UndampedMotor", JointMotor{Expression("0.9+t"), 20.0, 0.0, 3.0, Expression("2*t")}, angle},
      {"UndampedMotorWithoutLimit", JointMotor{Expression("0.9+t"), 20.0, 0.0, {}, Expression("2*t")}, travel},
      {"GivenEffort", JointMotor{Expression("0"), 0.0, 0.0, {}, Expression("0.5+t")}, angle},
      {"WoundUpSpring", JointSpring{30.0, 0.4}, angle, {0, 1}, 2.5},
      {"MotorThatIsTurnsBehind",
       JointMotor{Expression("9.2 + t"), 20.0, 0.7, 300.0, Expression("0.5*t")},
       angle,
       {0, 1},
       2.5},
      {"StopsTurnsAway", JointStops{1.0 - 2.2 * turn, 1.0 + 2.2 * turn, 40.0, 0.05}, angle, {0, 1}, 2.5}};
  const auto number = cases.size();
  for (std::size_t k = 0; k < number; ++k) {
    EffortCase of_states = cases[k];
    of_states.name += "WithoutInertia";
    of_states.rates = JointRates::differences;
    cases.push_back(of_states);
  }
  return cases;
}

/// The second body turned about the axis of `angle`, through its middle, by whole turns and perhaps half of one.
Field turned(double turns, const Field& more) {
  const bool is_half = std::abs(std::remainder(turns, 1.0)) > 0.25;
  return [=](const Point& x) {
    const Point u = more(x);
    const bool moves = is_half && x[0] > 1.0 + 0.5 * TwoBodies::gap;
    return moves ? Point{u[0], u[1] + 1.0 - 2.0 * x[1], u[2] + 1.0 - 2.0 * x[2]} : u;
  };
}

TwoBodies::Terms terms_of(const EffortCase& c, const Solid& solid) {
  std::vector<int> body_of_cell;
  for (PetscInt cell = 0; cell < solid.layout().num_local_cells; ++cell) {
    const double x = solid.layout().position(solid.layout().nodes_of_cell(cell)[0])[0];
    body_of_cell.push_back(x < 1.0 + 0.5 * TwoBodies::gap ? 0 : 1);
  }
  std::vector<JointBody> bodies;
  for (const int body : {0, 1}) bodies.push_back(joint_body(solid.layout(), body_of_cell, body));
  const auto angle = c.turns > 0.0 ? std::make_shared<const double>(c.turns * turn) : nullptr;
  TwoBodies::Terms terms;
  terms.push_back(std::make_unique<JointEffort>(
      bodies, std::vector<JointEffort::Joint>{{c.bodies, c.coordinate, c.law, angle}}, c.rates));
  return terms;
}

class JointEfforts : public ::testing::TestWithParam<EffortCase> {
 protected:
  static TwoBodies::Terms make(const Solid& solid) { return terms_of(GetParam(), solid); }
  static Field place() { return turned(GetParam().turns, test::rough_field(0.05, 7)); }
  TwoBodiesFile file_;
};

class WoundUpJoint : public ::testing::Test {
 protected:
  TwoBodiesFile file_;
};

INSTANTIATE_TEST_SUITE_P(Laws, JointEfforts, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(JointEfforts, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(comm, file_.name, make, 1, place());
  test::expect_derivatives(bodies);
}

TEST_P(JointEfforts, HaveNoResultant) {
  if (GetParam().bodies[0] < 0) return;
  TwoBodies bodies(comm, file_.name, make, 1, place());
  test::expect_no_resultant(bodies);
}

TEST_P(JointEfforts, AreThoseOfOneRank) {
  test::expect_numbers_of_one_rank(file_.name, make, 1, place());
}

/// Of exactly half a turn atan2 has either sign.
TEST_F(WoundUpJoint, CountsWholeTurns) {
  constexpr double rest = 0.4;
  const auto torque_and_energy = [&](double turns) {
    const EffortCase c{"", JointSpring{30.0, rest}, JointAngle{{0.0, 0.6, 0.8}, {0.0, -0.8, 0.6}}, {0, 1}, turns};
    TwoBodies bodies(
        comm, file_.name, [&](const Solid& solid) { return terms_of(c, solid); }, 1, turned(turns, test::at_rest));
    const auto q = bodies.place();
    const Handle<Vec> r = bodies.potential->make_vector();
    bodies.potential->gradient(q.get(), r.get());
    return std::pair(test::norm(r.get()),
                     bodies.potential->accounts().energies({0.3, 1.0, nullptr}, q.get(), nullptr).front());
  };
  const auto [torque, energy] = torque_and_energy(0.5);
  for (const double turns : {1.5, 2.5, 7.5}) {
    const auto [more, stored] = torque_and_energy(turns);
    const double angle = turns * turn - rest, first = 0.5 * turn - rest;
    EXPECT_NEAR(more / torque, angle / first, 1e-10) << turns;
    EXPECT_NEAR(stored, 15.0 * angle * angle, 1e-9 * stored) << turns;
  }
  EXPECT_NEAR(energy, 15.0 * (0.5 * turn - rest) * (0.5 * turn - rest), 1e-9);
}

}  // namespace
}  // namespace pliant::test_joint_effort
