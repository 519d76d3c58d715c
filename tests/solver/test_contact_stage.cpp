// Stages with contact: coefficients refrozen until they stay, and barriers that neither guess nor step passes.
#include "energy/contact/contact.hpp"
#include "fem/selection.hpp"
#include "petsc/collective.hpp"
#include "solver/problem.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_contact_stage {
namespace {

using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double density = 1000.0, dt = 5e-3;

/// A cube of 1 m over a plane that slides along.
ProblemSpec over_a_belt(const NormalLaw& law, std::optional<FrictionUpdate> friction) {
  ProblemSpec spec;
  spec.law = make_law("neo-hookean", 1e6, 0.3);
  spec.density = density;
  spec.loads = [=](const Solid& solid) {
    auto facets = surface_facets(solid.mesh(), solid.layout(), [](const Point&) { return true; });
    const auto surface =
        std::make_shared<const ContactSurface>(solid.layout(), solid.pattern(), std::move(facets), law);
    const RigidMotion belt{{Expression("0.4*t"), Expression(), Expression()}, {0.0, 0.0, 1.0}, Expression(), {}};
    const auto plane = std::make_shared<const Obstacle>(make_distance(PlaneShape{{}, {0.0, 0.0, 1.0}}), belt);
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(std::make_unique<Contact>(surface, plane));
    if (friction) {
      terms.push_back(make_friction(surface, plane, {0.7, 0.0, 0.05}, {0.5}, *friction));
      terms.push_back(make_normal_damping(surface, plane, {0.5}, *friction));
    }
    return terms;
  };
  return spec;
}

class ContactStage : public ::testing::Test {
 protected:
  /// |r| with coefficients that follow q.
  double residual(Problem& problem, const StagePoint& stage, Vec q) {
    problem.potential().begin_stage(stage);
    const Handle<Vec> r = problem.potential().make_vector();
    problem.potential().gradient(q, r.get());
    return test::norm(r.get());
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, test::Shape::jittered, 2});
  });
};

TEST_F(ContactStage, IteratedCoefficientsAreThoseOfTheSolution) {
  const NormalLaw law{NormalKind::penalty, 3e7, 0.01, 0.0};
  std::vector<Handle<Vec>> solutions;
  for (const auto update : {FrictionUpdate::frozen, FrictionUpdate::iterated}) {
    Problem problem(comm, file_, over_a_belt(law, update));
    const Solid& solid = problem.solid();
    const auto q0 = solid.vector([](const Point& x) { return Point{0.0, 0.0, -0.001 * (1.0 + x[0])}; });
    const auto v0 = solid.vector([](const Point&) { return Point{0.1, 0.3, -0.5}; });
    const auto q = solid.vector(test::at_rest);
    const StageReport report = problem.solve(0.1, dt, q0, v0, q);
    ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    const StagePoint stage{0.1, dt, q0.get(), v0.get(), 1.0};
    EXPECT_LE(residual(problem, stage, q.get()), 1e-8 * problem.potential().force_scale(q.get()));
    solutions.push_back(q.share());
  }
  // Frozen coefficients are others, those of the stage's start.
  const double difference = test::distance(solutions[0].get(), solutions[1].get());
  EXPECT_GT(difference, 1e-3 * test::norm(solutions[1].get()));
}

// Thrown at 10 m/s from 2 cm: within one step inertia alone would carry the body through.
TEST_F(ContactStage, NoNodePassesABarrier) {
  Problem problem(comm, file_, over_a_belt({NormalKind::barrier, 3e7, 0.01, 0.0}, std::nullopt));
  const Solid& solid = problem.solid();
  auto q = solid.vector([](const Point&) { return Point{0.0, 0.0, 0.02}; });
  auto v = solid.vector([](const Point&) { return Point{0.0, 0.0, -10.0}; });
  double lowest = 1.0;
  for (int step = 1; step <= 10; ++step) {
    const auto q0 = test::moved(q.get(), 0.0, q.get());
    const StageReport report = problem.solve(step * dt, dt, q0, v, q);
    ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    check(VecWAXPY(v.get(), -1.0, q0.get(), q.get()));
    check(VecScale(v.get(), 1.0 / dt));
    const ConstArrayView u(q.get());
    for (PetscInt a = 0; a < solid.layout().num_owned_nodes; ++a) {
      lowest = std::min(lowest, solid.layout().position(a)[2] + u[3 * a + 2]);
    }
  }
  lowest = minimum(comm, lowest);
  EXPECT_GT(lowest, 0.0);
  EXPECT_LT(lowest, 0.01);
  EXPECT_GT(problem.statistics().capped_steps, 0);
}

// A start beyond the barrier, as an extrapolation may be: the last solution shows the way in.
TEST_F(ContactStage, AStartBeyondABarrierIsLeftFromTheLastSolution) {
  Problem problem(comm, file_, over_a_belt({NormalKind::barrier, 3e7, 0.01, 0.0}, std::nullopt));
  const Solid& solid = problem.solid();
  const auto above = solid.vector([](const Point&) { return Point{0.0, 0.0, 0.003}; });
  const auto below = solid.vector([](const Point&) { return Point{0.0, 0.0, -0.002}; });
  const auto still = solid.vector(test::at_rest), q = solid.vector(test::at_rest);
  EXPECT_EQ(problem.solve(0.0, dt, below, still, q).outcome, StageOutcome::retry);
  ASSERT_EQ(problem.solve(0.0, dt, above, still, q).outcome, StageOutcome::converged);
  const StageReport report = problem.solve(dt, dt, below, still, q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_TRUE(std::isfinite(problem.potential().value(q.get())));
}

}  // namespace
}  // namespace pliant::test_contact_stage
