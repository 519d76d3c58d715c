// Springs, dampers and motors of joints: derivatives, opposite forces, the same numbers on every number of ranks.
#include "energy/equation/incremental_potential.hpp"
#include "energy/near_springs.hpp"
#include "energy/rigid/joint_effort.hpp"
#include "petsc/collective.hpp"

#include <optional>
#include <string>

namespace pliant::test_joint_effort {
namespace {

using test::Point;
using test::Scratch;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.3;

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
          {"SpringToGround", JointSpring{30.0, 0.1}, travel, {-1, 1}},
          {"MotorOnGround", motor, angle, {-1, 0}}};
}

/// Two bodies, one of which moves against the other, in a stage.
struct TwoBodies {
  TwoBodies(MPI_Comm of, const std::string& file, const EffortCase& c) : solid(of, file, 1, 1) {
    std::vector<int> body_of_cell;
    for (PetscInt cell = 0; cell < solid.layout().num_local_cells; ++cell) {
      body_of_cell.push_back(solid.layout().position(solid.layout().nodes_of_cell(cell)[0])[0] < 1.0 + 0.5 * gap ? 0
                                                                                                                 : 1);
    }
    std::vector<JointBody> bodies;
    for (const int body : {0, 1}) bodies.push_back(joint_body(solid.layout(), body_of_cell, body));
    effort.emplace(bodies, std::vector<JointEffort::Joint>{{c.bodies, c.coordinate, c.law}});
    potential.emplace(solid.layout(), solid.pattern(), std::vector<const EnergyTerm*>{&*effort},
                      solid.nothing_prescribed());
    stage.emplace(solid, 0.3, 0.05, test::rough_field(0.02, 3), test::rough_field(0.3, 4));
    potential->begin_stage(stage->point);
  }
  Handle<Vec> place() const {
    return solid.vector([](const Point& x) {
      Point u;
      for (int i = 0; i < 3; ++i) u[static_cast<std::size_t>(i)] = 0.05 * test::rough(x, i, 7);
      return u;
    });
  }

  Solid solid;
  std::optional<JointEffort> effort;
  std::optional<IncrementalPotential> potential;
  std::optional<TestStage> stage;
};

class JointEfforts : public ::testing::TestWithParam<EffortCase> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
};

INSTANTIATE_TEST_SUITE_P(Laws, JointEfforts, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(JointEfforts, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(comm, file_, GetParam());
  IncrementalPotential& potential = *bodies.potential;
  const auto q = bodies.place(), d = bodies.solid.vector(test::rough_field(1.0, 5));
  const Handle<Vec> r = potential.make_vector(), before = potential.make_vector(), after = potential.make_vector();
  const Handle<Mat> K = potential.make_hessian();
  constexpr double h = 1e-6;
  const auto ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
  potential.gradient(q.get(), r.get());
  ASSERT_GT(test::norm(r.get()), 0.01);
  if (potential.is_potential()) {
    EXPECT_NEAR(test::dot(r.get(), d.get()), (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h),
                1e-6 * test::norm(r.get()));
  }
  potential.hessian(q.get(), K.get(), Projection::none);
  Handle<Vec> y = potential.make_vector();
  check(MatMult(K.get(), d.get(), y.get()));
  potential.gradient(ahead.get(), after.get());
  potential.gradient(behind.get(), before.get());
  check(VecAXPY(after.get(), -1.0, before.get()));
  check(VecScale(after.get(), 1.0 / (2.0 * h)));
  EXPECT_LT(test::distance(y.get(), after.get()), 1e-6 * test::norm(y.get()));
}

// What acts on one body acts on the other: no resultant.
TEST_P(JointEfforts, HaveNoResultant) {
  if (GetParam().bodies[0] < 0) return;
  TwoBodies bodies(comm, file_, GetParam());
  const auto q = bodies.place();
  const Handle<Vec> r = bodies.potential->make_vector();
  bodies.potential->gradient(q.get(), r.get());
  std::array<double, 3> total{};
  {
    const ConstArrayView entries(r.get());
    for (PetscInt i = 0; i < 3 * bodies.solid.layout().num_owned_nodes; ++i) total[i % 3] += entries[i];
  }
  sum_in_place(comm, total);
  for (const double component : total) EXPECT_NEAR(component, 0.0, 1e-12 * test::norm(r.get()));
}

TEST_P(JointEfforts, AreThoseOfOneRank) {
  TwoBodies many(comm, file_, GetParam()), alone(MPI_COMM_SELF, file_, GetParam());
  const auto numbers_of = [](TwoBodies& bodies) {
    const auto q = bodies.place(), d = bodies.solid.vector(test::rough_field(1.0, 5));
    const Handle<Vec> r = bodies.potential->make_vector();
    bodies.potential->gradient(q.get(), r.get());
    return std::array{bodies.potential->value(q.get()), test::dot(r.get(), d.get()), test::norm(r.get())};
  };
  const auto here = numbers_of(many), there = numbers_of(alone);
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-14) << i;
  }
}

}  // namespace
}  // namespace pliant::test_joint_effort
