// Equilibria of bodies whose displacements are tied to one another, against the same problems solved otherwise.
#include "material/states.hpp"
#include "solver/tied_problem.hpp"

#include <cmath>

#include <fmt/format.h>

namespace pliant::test_constraints {
namespace {

using test::face;
using test::Field;
using test::Point;
using test::Tied;
using test::TiedProblem;
using test::TiedSpec;
using test::turned;
using test::turned_back;
using testing_states::Quad;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double modulus = 1e6;

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

}  // namespace
}  // namespace pliant::test_constraints
