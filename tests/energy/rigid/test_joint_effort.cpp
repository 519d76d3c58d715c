// Springs, dampers and motors of joints: derivatives, opposite forces, the same numbers on every number of ranks.
#include "energy/rigid/joint_effort.hpp"
#include "energy/two_bodies.hpp"

#include <string>

namespace pliant::test_joint_effort {
namespace {

using test::Solid;
using test::TwoBodies;
using test::TwoBodiesFile;

const MPI_Comm comm = MPI_COMM_WORLD;

struct EffortCase {
  std::string name;
  JointLaw law;
  JointCoordinate coordinate;
  std::array<int, 2> bodies{0, 1};
};

std::ostream& operator<<(std::ostream& out, const EffortCase& c) {
  return out << c.name;
}

std::vector<EffortCase> every_case() {
  const JointAngle angle{{0.0, 0.6, 0.8}, {0.0, -0.8, 0.6}};
  const JointTravel travel{{1.1, 0.4, 0.6}, {0.6, 0.0, 0.8}};
  const JointMotor motor{Expression("0.3*sin(4*t)"), 20.0, 0.7, 2.0, Expression("0.5*t")};
  return {{"TurnedSpring", JointSpring{30.0, 0.4}, angle},
          {"Spring", JointSpring{30.0, 0.1}, travel},
          {"TurnedDamper", JointDamper{3.0}, angle},
          {"Damper", JointDamper{3.0}, travel},
          {"TurningMotor", motor, angle},
          {"Motor", motor, travel},
          {"TurnedStops", JointStops{0.3, 0.25, 40.0, 0.05}, angle},
          {"TurnedStopsWithinTheirRounding", JointStops{0.3, 0.25, 40.0, 0.5}, angle},
          {"Stops", JointStops{0.2, 0.1, 40.0, 0.02}, travel},
          {"TurningFriction", JointFriction{0.7, 0.4}, angle},
          {"Friction", JointFriction{0.7, 0.4}, travel},
          {"TurningBearing", BearingFriction{std::make_shared<double>(0.7), 0.4}, angle},
          {"SpringToGround", JointSpring{30.0, 0.1}, travel, {-1, 1}},
          {"MotorOnGround", motor, angle, {-1, 0}}};
}

class JointEfforts : public ::testing::TestWithParam<EffortCase> {
 protected:
  static TwoBodies::Terms make(const Solid& solid) {
    const EffortCase& c = GetParam();
    std::vector<int> body_of_cell;
    for (PetscInt cell = 0; cell < solid.layout().num_local_cells; ++cell) {
      const double x = solid.layout().position(solid.layout().nodes_of_cell(cell)[0])[0];
      body_of_cell.push_back(x < 1.0 + 0.5 * TwoBodies::gap ? 0 : 1);
    }
    std::vector<JointBody> bodies;
    for (const int body : {0, 1}) bodies.push_back(joint_body(solid.layout(), body_of_cell, body));
    TwoBodies::Terms terms;
    terms.push_back(
        std::make_unique<JointEffort>(bodies, std::vector<JointEffort::Joint>{{c.bodies, c.coordinate, c.law}}));
    return terms;
  }
  TwoBodiesFile file_;
};

INSTANTIATE_TEST_SUITE_P(Laws, JointEfforts, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(JointEfforts, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(comm, file_.name, make);
  test::expect_derivatives(bodies);
}

TEST_P(JointEfforts, HaveNoResultant) {
  if (GetParam().bodies[0] < 0) return;
  TwoBodies bodies(comm, file_.name, make);
  test::expect_no_resultant(bodies);
}

TEST_P(JointEfforts, AreThoseOfOneRank) {
  test::expect_numbers_of_one_rank(file_.name, make);
}

}  // namespace
}  // namespace pliant::test_joint_effort
