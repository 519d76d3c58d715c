// Bodies whose displacements are tied to one another, against the same problems solved otherwise.
#include "energy/tied_body.hpp"
#include "material/states.hpp"
#include "solver/constrained_newton.hpp"
#include "solver/problem.hpp"
#include "time/integrator.hpp"
#include "time/method.hpp"

#include <cmath>
#include <map>

#include <fmt/format.h>

namespace pliant::test_constraints {
namespace {

using test::face;
using test::Field;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TiedBody;
using test::TiedSpec;
using testing_states::Quad;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double modulus = 1e6;

/// A tied body and its solver.
struct TiedProblem {
  TiedProblem(MPI_Comm on, const std::string& file, const TiedSpec& spec, LinearKind linear = LinearKind::cholesky)
      : body(on, file, spec), solver(body.potential(), body.map(), {.relative = 1e-12}, linear) {}

  /// The equilibrium at t = 1 from rest, in `steps` equal parts.
  Handle<Vec> equilibrium(int steps = 1) {
    Handle<Vec> q = body.solid().vector(test::at_rest);
    for (int s = 1; s <= steps; ++s) {
      const auto q0 = test::moved(q.get(), 0.0, q.get()), v0 = body.solid().vector(test::at_rest);
      const StagePoint stage{1.0, 1.0, q0.get(), v0.get(), static_cast<double>(s) / steps};
      body.motion().start_stage(stage, q.get());
      const StageReport report = solver.solve(stage, q.get());
      EXPECT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    }
    EXPECT_LE(body.violation(q.get(), 1.0), 1e-14);
    return q;
  }

  TiedBody body;
  ConstrainedNewton solver;
};

class Tied : public ::testing::Test {
 protected:
  /// A cube; `map` moves its nodes.
  std::string cube(int n, const std::function<Point(Point)>& map = nullptr) const {
    return scratch_.file("cube.msh", [&](const std::string& f) {
      test::BoxOptions options;
      options.map = map;
      test::write_box_msh(f, {1.0, 1.0, 1.0}, {n, n, n}, options);
    });
  }

  Scratch scratch_{comm};
};

/// About the axis (1, 2, 2) / 3.
const Point turned_by{0.7 / 3.0, 1.4 / 3.0, 1.4 / 3.0};
Point turned(const Point& x) {
  return turn(turned_by, x);
}
Point turned_back(const Point& x) {
  return turn(-1.0 * turned_by, x);
}
Region turned(const Region& region) {
  return [=](const Point& x) { return region(turned_back(x)); };
}

// Planes of symmetry in any direction: a cube pressed and sheared between three of them and a lid, and the same cube
// turned.
TEST_F(Tied, ObliquePlanesAreTurnedOnes) {
  TiedSpec spec;
  spec.order = 2;
  spec.law = make_law("neo-hookean", modulus, 0.3);
  test::TestConstraint lid{test::vector("0.2*t*y", "0.05*t", "-0.15*t"), face(2, 1.0)};
  spec.constraints = {lid};
  for (int axis = 0; axis < 3; ++axis) {
    test::TestConstraint plane{{}, [=](const Point& x) { return face(axis, 0.0)(x) && !face(2, 1.0)(x); }};
    plane.given.components[static_cast<std::size_t>(axis)] = Expression(0.0);
    spec.constraints.push_back(plane);
  }
  TiedProblem straight(comm, cube(2), spec);
  const auto u = straight.equilibrium();

  // The lid's displacement along the turned axes; the planes as ties.
  std::array<std::string, 3> lid_formula;
  const Point y_axis = turned(Point{0.0, 1.0, 0.0});
  const std::string y = fmt::format("({}*x+({})*y+({})*z)", y_axis[0], y_axis[1], y_axis[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = turned(Point{0.2, 0.0, 0.0})[i], b = turned(Point{0.0, 0.05, -0.15})[i];
    lid_formula[i] = fmt::format("({})*t*{}+({})*t", a, y, b);
  }
  TiedSpec oblique = spec;
  oblique.constraints = {{test::vector(lid_formula[0], lid_formula[1], lid_formula[2]), turned(face(2, 1.0))}};
  for (int axis = 0; axis < 3; ++axis) {
    Point normal{};
    normal[static_cast<std::size_t>(axis)] = -1.0;
    const Region plane = [=](const Point& x) { return face(axis, 0.0)(x) && !face(2, 1.0)(x); };
    oblique.constraints.push_back(test::slide(turned(plane), turned(normal), "0"));
  }
  TiedProblem other(comm, cube(2, [](Point x) { return turned(x); }), oblique);
  const auto w = other.equilibrium();
  EXPECT_NEAR(other.body.strain_energy(w.get()), straight.body.strain_energy(u.get()),
              1e-12 * straight.body.strain_energy(u.get()));
  EXPECT_GT(straight.body.strain_energy(u.get()), 1e-3 * modulus);

  // Node by node, each problem whole on every rank.
  TiedProblem alone(MPI_COMM_SELF, cube(2), spec);
  const Field expected = test::by_place(alone.body.solid(), alone.equilibrium().get());
  const double worst = test::deviation(other.body.solid(), w.get(), [&](const Point& x) {
    Point X = turned_back(x);
    for (double& X_i : X) X_i = std::round(4.0 * X_i) / 4.0;  // nodes of P2 are there
    return turned(expected(X));
  });
  EXPECT_LE(worst, 1e-11);
}

/// P of the stretches (l, m, m), by the textbook.
double stress(const ElasticLawSpec& law, double l, double m, int component) {
  const Tensor3<Quad> H{{Quad(l) - 1, 0, 0, 0, Quad(m) - 1, 0, 0, 0, Quad(m) - 1}};
  return static_cast<double>(testing_states::textbook_P(instantiate(law), H)(component, component));
}

// A cell whose faces repeat one another, stretched along x, free to contract: the homogeneous state of every law, whose
// force per area is the multiplier of the given difference. Edges and corners are reached in several ways.
TEST_F(Tied, PeriodicCellHasTheHomogeneousState) {
  for (const auto& law : test::every_law(modulus, 0.3)) {
    if (law.traits().num_directions == 2) continue;  // its sides differ
    double low = 0.5, high = 1.5;                    // the lateral stress grows with m
    for (int i = 0; i < 60; ++i) {
      const double m = 0.5 * (low + high);
      (stress(law, 1.2, m, 1) < 0 ? low : high) = m;
    }
    const double m = 0.5 * (low + high);
    TiedSpec spec;
    spec.law = law;
    spec.constraints = {{test::vector("0", "0", "0"), [](const Point& x) { return dot(x, x) < 1e-12; }},
                        test::repeat(face(0, 0.0), face(0, 1.0), test::vector("0.2*t", "0", "0")),
                        test::repeat(face(1, 0.0), face(1, 1.0), {{Expression(0.0), std::nullopt, Expression(0.0)}}),
                        test::repeat(face(2, 0.0), face(2, 1.0), {{Expression(0.0), Expression(0.0), std::nullopt}})};
    TiedProblem problem(comm, cube(3), spec);
    const auto q = problem.equilibrium();
    const Field exact = [=](const Point& x) { return Point{0.2 * x[0], (m - 1.0) * x[1], (m - 1.0) * x[2]}; };
    EXPECT_LE(test::deviation(problem.body.solid(), q.get(), exact), 1e-11) << test::name_of(law);
    const Handle<Vec> r = problem.body.potential().make_vector();
    problem.body.potential().gradient_with_reactions(q.get(), r.get());
    const auto multipliers = problem.body.map().multipliers(r.get());
    const double T = stress(law, 1.2, m, 0);
    for (std::size_t source = 1; source < 4; ++source) {
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(sum(comm, multipliers[source][i]), source == 1 && i == 0 ? T : 0.0, 1e-9 * T);
      }
    }
  }
}

/// A bar of the section 1 x 1 and the length 4 along x, held at x = 0 and gripped at the other end.
TiedSpec gripped(const RigidMotion& motion) {
  TiedSpec spec;
  spec.order = 2;
  spec.law = make_law("neo-hookean", modulus, 0.25);
  spec.constraints = {{test::vector("0", "0", "0"), face(0, 0.0)}, test::grip(face(0, 4.0), motion)};
  return spec;
}

class Twist : public Tied {
 protected:
  static constexpr double length = 4.0;
  std::string bar_ = scratch_.file("bar.msh", [](const std::string& f) {
    test::BoxOptions options;
    options.origin = {0.0, -0.5, -0.5};
    test::write_box_msh(f, {length, 1.0, 1.0}, {6, 3, 3}, options);
  });
  /// Turned about its axis, free along it.
  static RigidMotion turning(double angle) {
    return {{std::nullopt, Expression(0.0), Expression(0.0)}, {1.0, 0.0, 0.0}, Expression(angle), {length, 0.0, 0.0}};
  }
  struct State {
    double energy;
    test::Resultant grip;  // about the origin, which lies on the axis
    double lengthening;
  };
  State state(double angle, int steps) {
    TiedProblem problem(comm, bar_, gripped(turning(angle)));
    const auto q = problem.equilibrium(steps);
    const Handle<Vec> r = problem.body.potential().make_vector();
    problem.body.potential().gradient_with_reactions(q.get(), r.get());
    double u = 0.0;
    {
      const ArrayView reaction(r.get());
      const ConstArrayView x(q.get());
      for (PetscInt a = 0; a < problem.body.layout().num_owned_nodes; ++a) {
        if (face(0, length)(problem.body.layout().position(a))) {
          u = x[3 * a];
        } else {
          for (int i = 0; i < 3; ++i) reaction[3 * a + i] = 0.0;
        }
      }
    }
    return {problem.body.strain_energy(q.get()), test::resultant(problem.body.solid(), r.get(), q.get()),
            maximum(comm, u)};
  }
};

// The square bar: T = G beta a^4 angle / length, beta = 0.140577 (Timoshenko & Goodier, Theory of Elasticity, 109), but
// that the held ends cannot warp, which stiffens a bar of four sides by some per cent.
TEST_F(Twist, SmallTorqueIsSaintVenants) {
  const double angle = 1e-3, G = modulus / 2.5;
  const auto twisted = state(angle, 1);
  const double T = G * 0.140577 * angle / length;
  EXPECT_GT(twisted.grip.moment[0], T);
  EXPECT_LT(twisted.grip.moment[0], 1.06 * T);
  EXPECT_NEAR(twisted.energy, 0.5 * twisted.grip.moment[0] * angle, 1e-5 * twisted.energy);
}

// At 100 degrees: the torque is dE/d(angle), nothing pulls along the axis, and the bar lengthens (Poynting).
TEST_F(Twist, LargeTorqueIsTheEnergysDerivative) {
  const double angle = 1.75, h = 0.02;
  const auto at = state(angle, 4);
  double slope = 0.0;
  for (const auto& [k, weight] : {std::pair{1, 8.0}, {-1, -8.0}, {2, -1.0}, {-2, 1.0}}) {
    slope += weight * state(angle + k * h, 4).energy / (12.0 * h);
  }
  EXPECT_NEAR(at.grip.moment[0], slope, 1e-6 * slope);
  EXPECT_LE(std::abs(at.grip.force[0]), 1e-8 * at.grip.moment[0]);
  EXPECT_GT(at.lengthening, 1e-3);
}

TEST_F(Twist, MultigridAndRanksGiveTheSame) {
  RigidMotion motion = turning(0.8);
  motion.translation = {std::nullopt, std::nullopt, Expression(0.3)};
  TiedProblem alone(MPI_COMM_SELF, bar_, gripped(motion)), several(comm, bar_, gripped(motion)),
      multigrid(comm, bar_, gripped(motion), LinearKind::amg);
  const Field expected = test::by_place(alone.body.solid(), alone.equilibrium(2).get());
  EXPECT_LE(test::deviation(several.body.solid(), several.equilibrium(2).get(), expected), 1e-9);
  EXPECT_LE(test::deviation(multigrid.body.solid(), multigrid.equilibrium(2).get(), expected), 1e-9);
  // A bar with a grip that is free along two axes; multigrid solves what a clamped one takes a dozen iterations for.
  const auto& statistics = multigrid.solver.statistics();
  EXPECT_LE(statistics.linear_iterations, 40 * statistics.newton_iterations);
}

// A bar bent by a platen that turns by itself as its centre, off the axis, is moved aside: as by a grip that is given
// the angle which the platen takes, but that the grip needs no torque for it.
TEST_F(Twist, TurningPlatenIsAGripWithoutTorque) {
  RigidMotion moved{{Expression(-0.1), Expression(0.6), Expression(0.2)}, {0.0, 0.6, -0.8}, {}, {length, 0.2, 0.1}};
  for (const auto rotation : {FreeRotation::about_all_axes, FreeRotation::about_axis}) {
    TiedSpec spec = gripped(moved);
    spec.constraints[1] = test::platen(face(0, length), moved, rotation);
    TiedProblem free(comm, bar_, spec), multigrid(comm, bar_, spec, LinearKind::amg);
    const auto q = free.equilibrium(2);
    EXPECT_LE(free.body.distortion(0, q.get()), 1e-13);
    EXPECT_LE(test::distance(multigrid.equilibrium(2).get(), q.get()), 1e-8);
    const Placement at = free.body.placement(0, q.get());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(at.translation[i], (*moved.translation[i])(0.0, 0.0, 0.0, 0.0), 1e-13);
    }
    const Vector3<double> theta = logarithm(at.rotation);
    const double angle = std::sqrt(dot(theta, theta));
    EXPECT_GT(angle, 0.1);
    // With the curvature of the rotation in the Hessian Newton's method converges as it does elsewhere.
    EXPECT_LE(free.solver.statistics().newton_iterations, 16);

    RigidMotion given = moved;
    given.axis = (1.0 / angle) * theta;
    given.angle = Expression(angle);
    TiedProblem grip(comm, bar_, gripped(given));
    const auto u = grip.equilibrium(2);
    EXPECT_LE(test::distance(u.get(), q.get()), 1e-8);

    // The torque about the centre, and the reaction's part in it that is free, vanish.
    const Handle<Vec> r = free.body.potential().make_vector();
    free.body.potential().gradient_with_reactions(q.get(), r.get());
    {
      const ArrayView reaction(r.get());
      for (PetscInt a = 0; a < free.body.layout().num_owned_nodes; ++a) {
        if (face(0, length)(free.body.layout().position(a))) continue;
        for (int i = 0; i < 3; ++i) reaction[3 * a + i] = 0.0;
      }
    }
    const auto grips = test::resultant(free.body.solid(), r.get(), q.get());
    const Vector3<double> torque = grips.moment - cross(moved.centre + at.translation, grips.force);
    const double size = std::sqrt(dot(grips.force, grips.force));
    EXPECT_GT(size, 1e-3 * modulus);
    if (rotation == FreeRotation::about_all_axes) {
      EXPECT_LE(std::sqrt(dot(torque, torque)), 1e-8 * size);
    } else {
      EXPECT_LE(std::abs(dot(torque, moved.axis)), 1e-8 * size);
      EXPECT_GT(std::sqrt(dot(torque, torque)), 1e-2 * size);
    }
  }
}

/// sum of coefficient times the mean of a component over a region = `formula`.
test::TestConstraint balance(const Region& region, int component, const std::string& formula) {
  return {test::scalar(formula), nullptr, [=](const NodeLayout& layout, std::size_t source) {
            auto constraint = equation(layout, std::vector{test::mean(layout, region, component, 1.0)}, source);
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

struct OrderCase {
  int number;
  Method method;
  std::string name;
  std::vector<test::TestConstraint> constraints;
};

std::ostream& operator<<(std::ostream& out, const OrderCase& c) {
  return out << c.name << " " << c.method.name;
}

std::vector<OrderCase> every_order_case() {
  const RigidMotion turning{{Expression("0.1*sin(3*t)"), std::nullopt, Expression(0.0)},
                            {0.6, 0.0, 0.8},
                            Expression("2*t^2"),
                            {0.0, 0.5, 0.5}};
  const RigidMotion led{{Expression("0.1*sin(3*t)"), std::nullopt, Expression(0.0)}, {}, {}, {0.0, 0.4, 0.6}};
  const RigidMotion hinged{
      {Expression("0.1*t^2"), std::nullopt, Expression(0.0)}, {0.6, 0.0, 0.8}, {}, {-0.1, 0.5, 0.5}};
  const std::vector<std::pair<std::string, std::vector<test::TestConstraint>>> kinds{
      {"Grip", {test::grip(face(0, 0.0), turning)}},
      {"Ties",
       {test::slide(face(0, 0.0), {0.8, 0.6, 0.0}, "0.1*sin(2*t)*(1+y)"),
        test::repeat(face(2, 0.0), face(2, 1.0), {{Expression("0.05*t^2"), std::nullopt, Expression(0.0)}})}},
      {"Turning", {test::platen(face(0, 0.0), led, FreeRotation::about_all_axes)}},
      {"Flying", {test::platen(face(0, 0.0), {}, FreeRotation::about_all_axes)}},
      {"Hinged", {test::platen(face(0, 0.0), hinged, FreeRotation::about_axis)}},
      {"Kinked", {{test::vector("0.1*max(0, t-0.25) + t^2*min(t, 0.25)", "0", "0.1*abs(t-0.25)"), face(0, 0.0)}}},
      {"KinkedTies", {test::slide(face(0, 0.0), {0.8, 0.6, 0.0}, "0.2*max(0, t-0.25)*(1+y)")}}};
  std::vector<OrderCase> cases;
  for (const auto& [name, constraints] : kinds) {
    for (const Method& method : methods()) {
      cases.push_back({static_cast<int>(cases.size()), method, name, constraints});
    }
  }
  return cases;
}

class TiedOrders : public ::testing::TestWithParam<OrderCase> {
 protected:
  static constexpr double end_time = 0.5;
  static constexpr int num_fine = 96;

  /// (q, v) at the end of `num_steps` steps, on one rank alone; with an event at half the time.
  static std::array<Handle<Vec>, 2> end(TiedProblem& problem, const Method& method, int num_steps, bool has_kink) {
    auto q = problem.body.solid().vector(test::at_rest);
    auto v = problem.body.solid().vector([](const Point& x) {
      return Point{0.2 * x[1], -0.1 * x[0], 0.3 * x[0] * x[1]};
    });
    const PrescribedMotion motion = problem.body.motion();
    motion.complete_step({0.0, end_time / num_steps}, q.get(), v.get());
    System system{[&](const StagePoint& stage, Vec at) { return problem.solver.solve(stage, at); }, motion};
    system.guess = Guess::extrapolated;
    Integrator integrator({method, Startup::dirk33}, system, {0.0, q.get(), v.get(), nullptr, {}});
    for (int n = 1; n <= num_steps; ++n) {
      const double time = end_time * n / num_steps;
      const StepAttempt attempt = integrator.attempt({time, time - integrator.state().time});
      EXPECT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
      if (attempt.report.outcome != StageOutcome::converged) break;
      integrator.accept(attempt);
      if (has_kink && time == 0.5 * end_time) integrator.restart();
    }
    check(VecCopy(integrator.state().q.get(), q.get()));
    check(VecCopy(integrator.state().v.get(), v.get()));
    EXPECT_LE(problem.body.violation(q.get(), end_time), 1e-13);
    return {std::move(q), std::move(v)};
  }
  static bool has_event(const std::string& name) { return name.starts_with("Kinked"); }
  /// What the errors are measured against: once for all methods.
  static const std::array<Handle<Vec>, 2>& reference(TiedProblem& problem, const std::string& name) {
    const auto found = references.find(name);
    if (found != references.end()) return found->second;
    return references.emplace(name, end(problem, *find_method("dirk33"), 4 * num_fine, has_event(name))).first->second;
  }
  static void TearDownTestSuite() { references.clear(); }

 private:
  static inline std::map<std::string, std::array<Handle<Vec>, 2>> references;
};

INSTANTIATE_TEST_SUITE_P(Registry, TiedOrders, ::testing::ValuesIn(every_order_case()), [](const auto& of) {
  std::string name = of.param.name + "_" + of.param.method.name;
  std::erase(name, '-');
  return name;
});

// Constraints that move cost no method its order, in q or v; nor do jumps of what is given of velocities and
// accelerations, at an event.
TEST_P(TiedOrders, AreThoseOfTheMethod) {
  const OrderCase& c = GetParam();
  if (c.number % num_ranks(comm) != rank(comm)) return;  // another rank's
  const Scratch scratch(MPI_COMM_SELF);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 1});
  });
  TiedSpec spec;
  spec.law = make_law("neo-hookean", 5.0, 0.3);  // it vibrates at some rad/s
  spec.density = 1.0;
  spec.constraints = c.constraints;
  spec.rigidity = Rigidity::of_accelerations;
  TiedProblem problem(MPI_COMM_SELF, file, spec);
  const auto& exact = reference(problem, c.name);
  const bool has_kink = has_event(c.name);
  const auto coarse = end(problem, c.method, num_fine / 2, has_kink), fine = end(problem, c.method, num_fine, has_kink);
  for (const std::size_t part : {0, 1}) {
    const double error = test::distance(coarse[part].get(), exact[part].get());
    const double finer = test::distance(fine[part].get(), exact[part].get());
    EXPECT_NEAR(std::log2(error / finer), c.method.order, 0.15)
        << (part == 0 ? "q" : "v") << ": errors " << error << ", " << finer;
  }
}

}  // namespace
}  // namespace pliant::test_constraints
