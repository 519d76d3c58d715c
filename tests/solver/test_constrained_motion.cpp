// Motions of bodies whose displacements are tied to one another: their start, their momenta.
#include "solver/tied_problem.hpp"
#include "time/integrator.hpp"
#include "time/method.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace pliant::test_constrained_motion {
namespace {

using test::face;
using test::Field;
using test::Point;
using test::Tied;
using test::TiedBody;
using test::TiedProblem;
using test::TiedSpec;
using test::turned;
using test::turned_back;

const MPI_Comm comm = MPI_COMM_WORLD;

/// sum of coefficient times the mean of a component over a region = `formula`.
test::TestConstraint balance(const Region& region, int component, const std::string& formula) {
  return {test::scalar(formula), nullptr, [=](const NodeLayout& layout, std::size_t source) {
            auto constraint = tie_of_means(layout, std::vector{test::mean(layout, region, component, 1.0)}, source);
            return rank(layout.comm) == 0 ? std::vector{std::move(constraint)} : std::vector<LinearConstraint>();
          }};
}

/// Every kind of constraint, moving from the start on.
std::vector<std::pair<std::string, std::vector<test::TestConstraint>>> every_moving_constraint() {
  const RigidMotion turning{
      {Expression("0.3*t"), std::nullopt, Expression(0.0)}, {0.6, 0.0, 0.8}, Expression("2*t"), {0.0, 0.5, 0.5}};
  const RigidMotion led{{Expression("0.3*t"), std::nullopt, Expression(0.0)}, {}, {}, {0.0, 0.4, 0.6}};
  const RigidMotion hinged{{Expression("0.2*t"), std::nullopt, Expression(0.0)}, {0.6, 0.0, 0.8}, {}, {-0.1, 0.5, 0.5}};
  return {
      {"prescribed", {{test::vector("0.3*t*(1+y)", "0", "0.1*t^2"), face(0, 0.0)}}},
      {"oblique", {test::slide(face(0, 0.0), {0.8, 0.6, 0.0}, "0.1*sin(2*t)*(1+y)")}},
      {"periodic", {test::repeat(face(2, 0.0), face(2, 1.0), {{Expression("0.5*t"), std::nullopt, Expression(0.0)}})}},
      {"grip", {test::grip(face(0, 0.0), turning)}},
      {"equation", {balance(face(0, 1.0), 2, "0.5*sin(t)"), {test::vector("0", "0", "0"), face(0, 0.0)}}},
      {"all ties",
       {balance(face(0, 1.0), 1, "0.5*sin(t)"), test::slide(face(0, 0.0), {0.8, 0.6, 0.0}, "0.1*sin(2*t)*(1+y)"),
        test::repeat(face(2, 0.0), face(2, 1.0), {{Expression("0.05*t^2"), std::nullopt, Expression("0.1*t")}})}},
      {"turning", {test::platen(face(0, 0.0), led, FreeRotation::about_all_axes)}},
      {"hinged", {test::platen(face(0, 0.0), hinged, FreeRotation::about_axis)}}};
}

TiedSpec dynamic(std::vector<test::TestConstraint> constraints) {
  TiedSpec spec;
  spec.law = make_law("neo-hookean", 20.0, 0.3);
  spec.density = 1.0;
  spec.rigidity = Rigidity::of_accelerations;
  spec.constraints = std::move(constraints);
  return spec;
}

// Of all velocities that the constraints allow the one that is nearest to those asked for, in kinetic energy: the
// difference does no work with any other motion that they allow. It does not depend on what are slaves, which differ
// from one numbering to another: each problem whole on every rank gives the same.
TEST_F(Tied, StartVelocitiesAreTheNearest) {
  const Field wanted = [](const Point& x) { return Point{0.2 * x[1], 0.4 - 0.1 * x[0], 0.3 * x[0] * x[1] - 0.2}; };
  for (const auto& [name, constraints] : every_moving_constraint()) {
    TiedProblem problem(comm, cube(2), dynamic(constraints));
    TiedBody& body = problem.body;
    const auto start = [&](TiedBody& of) {
      auto v = of.solid().vector(wanted);
      const auto q = of.solid().vector(test::at_rest);
      of.motion().restart({0.0, 0.05}, q.get(), v.get());
      return v;
    };
    const auto v = start(body);
    const double h = 1e-5;
    EXPECT_LE(body.violation(test::moved(body.solid().vector(test::at_rest).get(), h, v.get()).get(), h), 10.0 * h * h)
        << name;
    const auto change = test::moved(v.get(), -1.0, body.solid().vector(wanted).get());
    const auto size = test::norm(change.get());
    EXPECT_GT(size, 0.05) << name;
    body.map().linearize_at(body.solid().vector(test::at_rest).get());
    for (const double phase : {0.0, 1.0, 2.0}) {
      const auto free = body.solid().vector([&](const Point& x) {
        return Point{std::cos(7.0 * x[0] + phase), std::cos(5.0 * x[1] + 2.0 * phase), std::cos(9.0 * x[2] + x[0])};
      });
      {
        const ArrayView entries(free.get());
        for (std::size_t i = 0; i < body.map().is_slave().size(); ++i) {
          if (body.map().is_slave()[i] || body.potential().prescribed()[i]) entries[static_cast<PetscInt>(i)] = 0.0;
        }
      }
      const auto allowed = body.solid().vector(test::at_rest);
      check(MatMult(body.map().jacobian(), free.get(), allowed.get()));
      const auto w = test::local_values(allowed.get()), d = test::local_values(change.get());
      EXPECT_LE(std::abs(sum(comm, body.inertia().mass().product(w, d))), 1e-13) << name;
    }
    TiedProblem alone(MPI_COMM_SELF, cube(2), dynamic(constraints));
    const Field expected = test::by_place(alone.body.solid(), start(alone.body).get());
    EXPECT_LE(test::deviation(body.solid(), v.get(), expected), 1e-12) << name;
  }
}

// Where ends are drawn apart from rest, nothing pushes the body as a whole.
TEST_F(Tied, TiesThatStartToMoveGiveNoMomentum) {
  TiedProblem problem(comm, cube(2),
                      dynamic({test::repeat(face(0, 0.0), face(0, 1.0), test::vector("0.5*t", "0.2*t", "0"))}));
  const auto q = problem.body.solid().vector(test::at_rest), v = problem.body.solid().vector(test::at_rest);
  problem.body.motion().restart({0.0, 0.05}, q.get(), v.get());
  const Inertia& inertia = problem.body.inertia();
  const auto local = test::local_values(v.get());
  EXPECT_GT(sum(comm, inertia.kinetic_energy(local)), 1e-3);
  Momenta of = inertia.momenta(problem.body.layout().coordinates, test::local_values(q.get()), local);
  for (const double p : of.linear) EXPECT_NEAR(sum(comm, p), 0.0, 1e-14);
}

// What is oblique moves as what lies along an axis.
TEST_F(Tied, StartVelocitiesTurnWithTheBody) {
  TiedProblem straight(comm, cube(2), dynamic({{{{Expression("0.3*t"), std::nullopt, std::nullopt}}, face(0, 1.0)}}));
  const Region side = [](const Point& x) { return face(0, 1.0)(turned_back(x)); };
  TiedProblem oblique(comm, cube(2, [](Point x) { return turned(x); }),
                      dynamic({test::slide(side, turned(Point{1.0, 0.0, 0.0}), "0.3*t")}));
  const auto start = [](TiedBody& body) {
    const auto q = body.solid().vector(test::at_rest);
    auto v = body.solid().vector(test::at_rest);
    body.motion().restart({0.0, 0.05}, q.get(), v.get());
    return std::pair(sum(comm, body.inertia().kinetic_energy(test::local_values(v.get()))), test::norm(v.get()));
  };
  const auto [energy, size] = start(straight.body);
  const auto [turned_energy, turned_size] = start(oblique.body);
  EXPECT_NEAR(turned_energy, energy, 1e-13 * energy);
  EXPECT_NEAR(turned_size, size, 1e-13 * size);
  EXPECT_GT(energy, 1e-3);
}

// Methods act on coordinates along the constraints: which entries are slaves makes no difference, at no step.
TEST_F(Tied, MotionsDoNotDependOnTheNumbering) {
  for (const char* method : {"dirk22", "implicit-midpoint"}) {
    for (const auto& [name, constraints] : every_moving_constraint()) {
      const auto end = [&](TiedProblem& problem) {
        auto q = problem.body.solid().vector(test::at_rest), v = problem.body.solid().vector(test::at_rest);
        const PrescribedMotion motion = problem.body.motion();
        motion.restart({0.0, 0.1}, q.get(), v.get());
        System system{[&](const StagePoint& stage, Vec at) { return problem.solver.solve(stage, at); }, motion};
        Integrator integrator({*find_method(method)}, system, {0.0, q.get(), v.get(), nullptr, {}});
        for (int n = 1; n <= 4; ++n) {
          const StepAttempt attempt = integrator.attempt({0.1 * n, 0.1});
          EXPECT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
          integrator.accept(attempt);
          if (n == 2) integrator.restart();
        }
        check(VecCopy(integrator.state().v.get(), v.get()));
        return v;
      };
      TiedProblem several(comm, cube(2), dynamic(constraints)), alone(MPI_COMM_SELF, cube(2), dynamic(constraints));
      const Field expected = test::by_place(alone.body.solid(), end(alone).get());
      EXPECT_LE(test::deviation(several.body.solid(), end(several).get(), expected), 1e-9) << name << " " << method;
    }
  }
}

/// A block that flies and vibrates with two rigid sides.
TiedSpec flying(FreeRotation rotation) {
  TiedSpec spec;
  spec.law = make_law("neo-hookean", 20.0, 0.3);
  spec.density = 1.0;
  spec.rigidity = Rigidity::of_accelerations;
  spec.constraints = {test::platen(face(0, 0.0), {}, rotation), test::platen(face(0, 1.0), {}, rotation)};
  return spec;
}

Momenta momenta(const Inertia& inertia, const NodeLayout& layout, Vec q, Vec v) {
  Momenta total = inertia.momenta(layout.coordinates, test::local_values(q), test::local_values(v));
  for (auto* of : {&total.linear, &total.angular}) {
    for (double& component : *of) component = sum(layout.comm, component);
  }
  return total;
}

// The forces of the constraint have neither resultant nor moment, and what makes the sides rigid again gives none.
TEST_F(Tied, FlyingBodyWithRigidSidesKeepsItsMomenta) {
  TiedProblem problem(comm, cube(2), flying(FreeRotation::about_all_axes));
  const Inertia& inertia = problem.body.inertia();
  auto q = problem.body.solid().vector(test::at_rest);
  auto v = problem.body.solid().vector([](const Point& x) {
    return Point{0.3, 0.0, -0.2} + cross(Point{0.8, -0.5, 1.5}, x) + 0.2 * Point{x[0] * x[1], x[2] * x[2], x[1]};
  });
  const PrescribedMotion motion = problem.body.motion();
  motion.complete_step({0.0, 0.05}, q.get(), v.get());
  const Momenta before = momenta(inertia, problem.body.layout(), q.get(), v.get());
  System system{[&](const StagePoint& stage, Vec at) { return problem.solver.solve(stage, at); }, motion};
  Integrator integrator({*find_method("implicit-midpoint")}, system, {0.0, q.get(), v.get(), nullptr, {}});
  for (int n = 1; n <= 20; ++n) {
    const StepAttempt attempt = integrator.attempt({0.05 * n, 0.05});
    ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
    integrator.accept(attempt);
  }
  const auto& state = integrator.state();
  const Momenta after = momenta(inertia, problem.body.layout(), state.q.get(), state.v.get());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(after.linear[i], before.linear[i], 1e-12);
    EXPECT_NEAR(after.angular[i], before.angular[i], 1e-11);  // what Newton's tolerance leaves in each step
  }
  for (const std::size_t part : {0, 1}) {
    EXPECT_LE(problem.body.distortion(part, state.q.get()), 1e-14);
    EXPECT_LE(std::abs(problem.body.placement(part, state.q.get()).rotation[0]), 0.95);
  }
  // Newton's method converges as it does elsewhere.
  EXPECT_LE(problem.solver.statistics().newton_iterations, 20 * 6);
}

}  // namespace
}  // namespace pliant::test_constrained_motion
