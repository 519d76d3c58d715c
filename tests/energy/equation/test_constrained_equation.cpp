// The equation in the unknowns that constraints leave: its derivatives, and that its configurations fulfil them.
#include "energy/constraint/mechanism.hpp"
#include "energy/equation/constrained_equation.hpp"
#include "energy/screw_joint.hpp"
#include "energy/tied_body.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>

namespace pliant::test_constrained_equation {
namespace {

using test::Point;
using test::Scratch;
using test::Shape;
using test::TestConstraint;
using test::TestStage;
using test::TiedBody;
using test::TiedSpec;

const MPI_Comm comm = MPI_COMM_WORLD;

Region at(int axis, double value) {
  return [=](const Point& x) { return std::abs(x[axis] - value) < 1e-9; };
}

/// Every kind of tie at once; they share nodes, and some share them with what is prescribed.
TiedSpec everything(int order) {
  TiedSpec spec;
  spec.order = order;
  spec.law = make_law("neo-hookean", 1000.0, 0.3);
  spec.density = 3.0;
  spec.constraints.push_back({test::vector("0.01*t", "0", "0"), [](const Point& x) { return dot(x, x) < 1e-12; }});
  spec.constraints.push_back(test::slide(at(0, 0.0), {0.8, 0.6, 0.0}, "0.008*t"));
  spec.constraints.push_back(
      test::repeat(at(2, 0.0), at(2, 1.0), {{Expression(0.02), std::nullopt, Expression("0.01*t")}}));
  RigidMotion turn{{std::nullopt, Expression("0.02*t"), std::nullopt}, {0.0, 1.0, 0.0}, Expression("0.3*t"), {}};
  turn.centre = {1.0, 0.5, 0.5};
  spec.constraints.push_back(
      test::grip([](const Point& x) { return x[0] > 1.0 - 1e-9 && x[2] > 0.2 && x[2] < 0.8; }, turn));
  spec.constraints.push_back(
      {test::scalar("0.05*t"), nullptr, [](const NodeLayout& layout, std::size_t source) {
         const auto is_inside = [](double x) { return x > 0.3 && x < 0.7; };
         const auto inner = [=](const Point& x) { return is_inside(x[0]) && is_inside(x[1]) && is_inside(x[2]); };
         const auto on_side = [=](const Point& x) { return is_inside(x[0]) && x[1] > 1.0 - 1e-9 && is_inside(x[2]); };
         const std::array terms{test::mean(layout, inner, 2, 2.0), test::mean(layout, on_side, 0, -1.0)};
         const auto tie = tie_of_means(layout, terms, source);
         return rank(layout.comm) == 0 ? std::vector{tie} : std::vector<LinearConstraint>();
       }});
  spec.surroundings = Gas{3.0, 50.0, 400.0, 1.4, Expression(1.0)};
  return spec;
}

RigidMotion free_motion() {
  RigidMotion motion;
  motion.axis = {0.0, 0.6, 0.8};
  motion.centre = {0.9, 0.4, 0.3};
  return motion;
}

/// Rigid parts that turn: one by itself, one about an axis with a translation that is given in part.
TiedSpec turning(int order) {
  TiedSpec spec;
  spec.order = order;
  spec.law = make_law("neo-hookean", 1000.0, 0.3);
  spec.density = 3.0;
  spec.constraints.push_back(test::platen(at(0, 0.0), free_motion(), FreeRotation::about_all_axes));
  RigidMotion hinge = free_motion();
  hinge.translation = {std::nullopt, Expression("0.05*t"), std::nullopt};
  spec.constraints.push_back(test::platen(at(0, 1.0), hinge, FreeRotation::about_axis));
  spec.surroundings = Gas{3.0, 50.0, 400.0, 1.4, Expression(1.0)};
  return spec;
}

TiedSpec turning_in_time(int order) {
  TiedSpec spec = turning(order);
  spec.rigidity = Rigidity::of_accelerations;
  spec.surroundings = std::nullopt;
  return spec;
}

/// A joint coordinate next to a rigid part.
TiedSpec joint(int order) {
  TiedSpec spec = turning(order);
  spec.constraints.resize(1);
  TestConstraint& constraint = spec.constraints.emplace_back();
  constraint.dependent = [](const NodeLayout& layout) {
    return std::make_unique<test::ScrewJoint>(layout, nodes_in_region(layout, at(0, 1.0)), free_motion().centre,
                                              free_motion().axis, 0.3);
  };
  return spec;
}

/// Two slabs with equations of every kind between them and the ground, three of which move; the first turns by `angle`.
TiedSpec mechanism_turned_by(const std::string& angle, int order) {
  TiedSpec spec = turning(order);
  spec.constraints.resize(1);
  spec.constraints[0] = {};
  spec.constraints[0].dependent = [angle](const NodeLayout& layout) {
    std::vector<std::unique_ptr<RigidPart>> parts;
    for (const bool is_first : {true, false}) {
      const auto nodes = nodes_in_region(layout, [=](const Point& x) { return is_first ? x[0] < 0.4 : x[0] > 0.6; });
      parts.push_back(std::make_unique<RigidPart>(layout, nodes, RigidMotion{}, FreeRotation::about_all_axes));
    }
    const Vector3<double> centre = free_motion().centre, axis = free_motion().axis, e = {1.0, 0.0, 0.0};
    const Vector3<double> f = cross(axis, e);
    constexpr int ground = JointEquation::ground;
    std::vector<JointEquation> equations;
    for (std::size_t i = 0; i < 3; ++i) {
      Vector3<double> n{};
      n[i] = 1.0;
      equations.push_back({Coincidence{centre, n}, {ground, 0}, 0});
    }
    equations.push_back({Turn{e, f, Expression(angle)}, {ground, 0}, 0});
    equations.push_back({Perpendicularity{axis, e}, {0, 1}, 1});
    equations.push_back({Travel{{0.5, 0.4, 0.2}, f, Expression("0.02*t")}, {0, 1}, 1});
    equations.push_back({Distance{{0.2, 0.1, 0.3}, {0.9, 0.8, 0.4}, 1.0, Expression("0.05*t")}, {0, 1}, 2});
    return std::make_unique<Mechanism>(layout, std::move(parts), std::vector<char>{1, 0}, std::move(equations));
  };
  return spec;
}

TiedSpec mechanism(int order) {
  return mechanism_turned_by("0.95+0.1*t^2", order);
}

TiedSpec mechanism_in_time(int order) {
  TiedSpec spec = mechanism_turned_by("0.15+0.1*t^2", order);
  spec.rigidity = Rigidity::of_accelerations;
  spec.surroundings = std::nullopt;
  return spec;
}

TiedSpec with_pressures(TiedSpec spec) {
  spec.has_pressures = true;
  spec.law = make_law("neo-hookean", 1000.0, 0.49);
  return spec;
}

TiedSpec ties_with_pressures(int order) {
  return with_pressures(everything(order));
}
TiedSpec turning_with_pressures(int order) {
  return with_pressures(turning(order));
}
TiedSpec turning_in_time_with_pressures(int order) {
  return with_pressures(turning_in_time(order));
}

struct EquationCase {
  std::string name;
  TiedSpec (*spec)(int order);
  int order;
};

std::ostream& operator<<(std::ostream& out, const EquationCase& c) {
  return out << c.name << "P" << c.order;
}

class Constrained : public ::testing::TestWithParam<EquationCase> {
 protected:
  Constrained() {
    // From a guess that is turned, so that the Jacobian is not that of small rotations: by a radian, or by what is left
    // of that in one step.
    const bool turns = !body_.map().is_linear();
    const Vector3<double> theta = (body_.map().is_symmetric() ? 1.0 : 0.2) * Vector3<double>{0.0, 0.6, 0.8};
    const Point centre = free_motion().centre;
    const auto guess = body_.solid().vector([&](const Point& x) {
      return 0.1 * test::strained(x) + (turns ? turn(theta, x - centre) - (x - centre) : Point{});
    });
    equation_.enter(stage_.point, guess.get(), y_.get());
  }

  Handle<Vec> moved(Vec y, double alpha, Vec d) const {
    Handle<Vec> result = equation_.make_vector();
    check(VecWAXPY(result.get(), alpha, d, y));
    return result;
  }
  double value(double alpha, Vec d) { return equation_.value(moved(y_.get(), alpha, d).get()); }
  Handle<Vec> gradient(double alpha, Vec d) {
    Handle<Vec> r = equation_.make_vector();
    equation_.gradient(moved(y_.get(), alpha, d).get(), r.get());
    return r;
  }
  Handle<Vec> displacements_of(Vec y) const {
    auto u = body_.solid().vector(test::at_rest);
    const ConstArrayView from(y);
    const ArrayView to(u.get());
    std::copy_n(from.span().begin(), to.span().size(), to.span().begin());
    return u;
  }
  /// A direction in which only unknowns change.
  Handle<Vec> direction(int seed) const {
    const auto u = body_.solid().vector(test::rough_field(0.02, seed));
    auto d = equation_.make_vector();
    {
      const ConstArrayView displacements(u.get());
      const ArrayView entries(d.get());
      std::ranges::copy(displacements.span(), entries.span().begin());
      for (std::size_t i = displacements.span().size(); i < entries.span().size(); ++i) {
        entries.span()[i] = 0.02 * std::cos(static_cast<double>(i) + seed);
      }
      for (std::size_t i = 0; i < entries.span().size(); ++i) {
        if (equation_.prescribed()[i]) entries.span()[i] = 0.0;
      }
    }
    return d;
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, GetParam().order == 1 ? 3 : 2});
  });
  TiedBody body_{comm, file_, GetParam().spec(GetParam().order)};
  ConstrainedEquation equation_{body_.equation(), body_.map()};
  TestStage stage_{body_.solid(), 0.7, 0.05, test::rough_field(0.01, 3), test::rough_field(0.3, 4)};
  Handle<Vec> y_ = equation_.make_vector();
};

INSTANTIATE_TEST_SUITE_P(
    Kinds, Constrained,
    ::testing::Values(
        EquationCase{"Ties", everything, 1}, EquationCase{"Ties", everything, 2}, EquationCase{"Turning", turning, 1},
        EquationCase{"Turning", turning, 2}, EquationCase{"Joint", joint, 1}, EquationCase{"Joint", joint, 2},
        EquationCase{"Mechanism", mechanism, 1}, EquationCase{"Mechanism", mechanism, 2},
        EquationCase{"MechanismInTime", mechanism_in_time, 1}, EquationCase{"MechanismInTime", mechanism_in_time, 2},
        EquationCase{"TurningInTime", turning_in_time, 1}, EquationCase{"TurningInTime", turning_in_time, 2},
        EquationCase{"TiesWithPressures", ties_with_pressures, 2},
        EquationCase{"TurningWithPressures", turning_with_pressures, 2},
        EquationCase{"TurningInTimeWithPressures", turning_in_time_with_pressures, 2}),
    [](const auto& of) { return of.param.name + "P" + std::to_string(of.param.order); });

TEST_P(Constrained, ConfigurationsFulfilAllConstraints) {
  if (!body_.map().is_linear()) return;
  // Entries of slaves have no meaning in y, those of prescribed ones are at their values.
  const auto q = body_.solid().vector(test::at_rest), v = body_.solid().vector(test::at_rest);
  const auto u = displacements_of(y_.get());
  check(VecCopy(u.get(), q.get()));
  body_.motion().complete_step({0.7, 0.05}, q.get(), v.get());
  EXPECT_LE(body_.violation(q.get(), 0.7), 1e-14);
  EXPECT_GT(body_.violation(u.get(), 0.7), 1e-3);
  const auto expanded = body_.solid().vector(test::at_rest);
  body_.map().begin_stage(stage_.point, q.get());
  body_.map().expand(q.get(), expanded.get());
  EXPECT_LE(test::distance(q.get(), expanded.get()), 1e-14);
}

// The stage's differences are exact where the constraints move.
TEST_P(Constrained, RatesOfAStageFulfilAllConstraints) {
  if (!body_.map().is_linear()) return;
  const auto u = displacements_of(y_.get());
  const double dt = 0.05, h = 1e-4;
  body_.motion().start_stage(stage_.point, u.get());
  EXPECT_LE(body_.violation(u.get(), 0.7), 1e-13);
  const auto v = test::moved(u.get(), -1.0, stage_.q0.get());
  check(VecScale(v.get(), 1.0 / dt));
  // Their constraints have the rates of what is given: q(0.7) + h v fulfils those at 0.7 + h, to h^2.
  EXPECT_LE(body_.violation(test::moved(u.get(), h, v.get()).get(), 0.7 + h), 0.1 * h * h);
  EXPECT_GT(body_.violation(u.get(), 0.7 + h), 0.005 * h);
}

TEST_P(Constrained, TurningPartsAreRigid) {
  if (body_.map().is_linear() || !body_.map().is_symmetric()) return;
  const auto q = body_.solid().vector(test::at_rest);
  body_.map().expand(displacements_of(y_.get()).get(), q.get());
  for (std::size_t part = 0; part < body_.num_turning_parts(); ++part) {
    EXPECT_LE(body_.distortion(part, q.get()), 1e-14);
    const auto placement = body_.placement(part, q.get());
    EXPECT_GT(placement.rotation[2], 0.2);
    if (part == 0) continue;
    EXPECT_NEAR(placement.translation[1], 0.05 * 0.7, 1e-14);
    const auto theta = logarithm(placement.rotation);
    EXPECT_NEAR(0.8 * theta[1] - 0.6 * theta[2], 0.0, 1e-13);  // about the axis alone
    EXPECT_NEAR(theta[0], 0.0, 1e-13);
  }
}

// The unknowns of a configuration that fulfils the constraints are found again.
TEST_P(Constrained, RestrictionIsTheInverse) {
  if (!body_.map().is_symmetric()) return;
  const auto q = body_.solid().vector(test::at_rest), again = body_.solid().vector(test::at_rest);
  const auto y = displacements_of(y_.get()), z = body_.solid().vector(test::at_rest);
  body_.map().expand(y.get(), q.get());
  body_.map().restrict(q.get(), z.get());
  body_.map().expand(z.get(), again.get());
  EXPECT_LE(test::distance(q.get(), again.get()), 1e-13);
  // And in a stage that begins elsewhere.
  body_.map().begin_stage(stage_.point, body_.solid().vector(test::at_rest).get());
  body_.map().restrict(q.get(), z.get());
  body_.map().expand(z.get(), again.get());
  EXPECT_LE(test::distance(q.get(), again.get()), 1e-13);
}

// The columns of J are the derivatives of T; fourth order, as below.
TEST_P(Constrained, JacobianIsTheDerivative) {
  const auto y = displacements_of(y_.get()), d = displacements_of(direction(11).get());
  const auto expanded = [&](double alpha) {
    auto q = body_.solid().vector(test::at_rest);
    body_.map().expand(test::moved(y.get(), alpha, d.get()).get(), q.get());
    return q;
  };
  const double h = 1e-3;
  const auto Jd = body_.solid().vector(test::at_rest), difference = body_.solid().vector(test::at_rest);
  body_.map().linearize(y.get());
  check(MatMult(body_.map().jacobian(), d.get(), Jd.get()));
  check(VecWAXPY(difference.get(), -1.0, expanded(-h).get(), expanded(h).get()));
  check(VecScale(difference.get(), 8.0));
  check(VecAXPY(difference.get(), -1.0, expanded(2.0 * h).get()));
  check(VecAXPY(difference.get(), 1.0, expanded(-2.0 * h).get()));
  check(VecScale(difference.get(), 1.0 / (12.0 * h)));
  ASSERT_GT(test::norm(Jd.get()), 1e-3);
  EXPECT_LE(test::distance(Jd.get(), difference.get()), 1e-10 * test::norm(Jd.get()));
}

// The second derivative of F^T F = I with the rates of the stage, on the plane of the nodes; of the hinge across its
// axis.
TEST_P(Constrained, TurningPartsAccelerateAsRigidOnes) {
  if (body_.map().is_symmetric()) return;
  const double dt = 0.05;
  const auto guess = displacements_of(y_.get());
  body_.motion().start_stage(stage_.point, guess.get());
  equation_.enter(stage_.point, guess.get(), y_.get());
  const auto q = body_.solid().vector(test::at_rest);
  body_.map().expand(displacements_of(y_.get()).get(), q.get());
  const auto centre = free_motion().centre;
  for (int part = 0; part < static_cast<int>(body_.num_turning_parts()); ++part) {
    const auto nodes = nodes_in_region(body_.layout(), at(0, part));
    const AffineFit fit = part == 0 ? AffineFit(body_.layout(), nodes, centre)
                                    : AffineFit(body_.layout(), nodes, centre, free_motion().axis);
    const auto [u, H] = fit(body_.layout(), nodes, q.get());
    const auto [u0, H0] = fit(body_.layout(), nodes, stage_.q0.get());
    const auto [v0, V0] = fit(body_.layout(), nodes, stage_.v0.get());
    const Tensor3<double> F = add_to_diagonal(H, 1.0), V = (1.0 / dt) * (H - H0), A = (1.0 / dt) * (V - V0);
    const Tensor3<double> FA = matmul(transpose(F), A), VV = matmul(transpose(V), V);
    ASSERT_GT(VV(1, 1), 1e-3);
    for (int i = 1; i < 3; ++i) {
      for (int j = 1; j < 3; ++j) EXPECT_NEAR(FA(i, j) + FA(j, i) + 2.0 * VV(i, j), 0.0, 1e-11);
    }
    if (part == 0) continue;
    // Where the centre is led, its velocity and acceleration are exact, too.
    EXPECT_NEAR(u[1], 0.05 * 0.7, 1e-14);
    EXPECT_NEAR((u[1] - u0[1]) / dt, 0.05, 1e-11);
    EXPECT_NEAR(v0[1], 0.05, 1e-11);
  }
}

// At the end of a step positions and velocities are rigid, and those that were so stay as they are.
TEST_P(Constrained, StepsEndRigid) {
  if (body_.map().is_linear()) return;
  const auto q = body_.solid().vector([](const Point& x) { return 0.1 * test::strained(x); });
  const auto v = body_.solid().vector(test::rough_field(0.3, 5));
  body_.motion().complete_step({0.7, 0.05}, q.get(), v.get());
  for (std::size_t part = 0; part < body_.num_turning_parts(); ++part) {
    EXPECT_LE(body_.distortion(part, q.get()), 1e-14);
    const double h = 1e-5;
    EXPECT_LE(body_.distortion(part, test::moved(q.get(), h, v.get()).get()), 2.0 * h * h);
  }
  const auto q2 = test::moved(q.get(), 0.0, q.get()), v2 = test::moved(v.get(), 0.0, v.get());
  body_.motion().complete_step({0.7, 0.05}, q2.get(), v2.get());
  EXPECT_LE(test::distance(q.get(), q2.get()), body_.num_turning_parts() == 2 ? 0.0 : 1e-14);  // others to rounding
  EXPECT_LE(test::distance(v.get(), v2.get()), 1e-14);
}

// Differences of fourth order: their error is some 1e-12, their rounding some 1e-12, of the derivative.
constexpr double h = 1e-3;

TEST_P(Constrained, GradientIsThatOfTheValue) {
  if (!equation_.is_potential()) return;
  const auto g = gradient(0.0, y_.get());
  ASSERT_GT(test::norm(g.get()), 1e-3);
  for (const int seed : {11, 12}) {
    const auto d = direction(seed);
    const double expected =
        (8.0 * (value(h, d.get()) - value(-h, d.get())) - (value(2.0 * h, d.get()) - value(-2.0 * h, d.get()))) /
        (12.0 * h);
    EXPECT_NEAR(test::dot(g.get(), d.get()), expected, 1e-9 * test::norm(g.get()) * test::norm(d.get()));
  }
}

TEST_P(Constrained, HessianIsThatOfTheGradient) {
  const Handle<Mat> K = equation_.make_hessian();
  equation_.hessian(moved(y_.get(), 0.3, y_.get()).get(), K.get(), Projection::none);  // the pattern is reused
  equation_.hessian(y_.get(), K.get(), Projection::none);
  std::vector<RankOne> parts(equation_.num_rank_one());
  ASSERT_EQ(parts.size(), GetParam().name.find("InTime") != std::string::npos ? 0u : 1u);  // of the gas around the body
  for (RankOne& part : parts) part.g = equation_.make_vector();
  equation_.rank_one_parts(y_.get(), parts);
  for (const RankOne& part : parts) EXPECT_GT(part.c, 0.0);
  const Handle<Vec> Kd = equation_.make_vector(), difference = equation_.make_vector();
  for (const int seed : {11, 12}) {
    const auto d = direction(seed);
    check(MatMult(K.get(), d.get(), Kd.get()));
    for (const RankOne& part : parts) {
      check(VecAXPY(Kd.get(), part.c * test::dot(part.g.get(), d.get()), part.g.get()));
    }
    const auto ahead = gradient(h, d.get()), behind = gradient(-h, d.get());
    const auto far_ahead = gradient(2.0 * h, d.get()), far_behind = gradient(-2.0 * h, d.get());
    check(VecWAXPY(difference.get(), -1.0, behind.get(), ahead.get()));
    check(VecScale(difference.get(), 8.0));
    check(VecAXPY(difference.get(), -1.0, far_ahead.get()));
    check(VecAXPY(difference.get(), 1.0, far_behind.get()));
    check(VecScale(difference.get(), 1.0 / (12.0 * h)));
    ASSERT_GT(test::norm(Kd.get()), 1e-3);
    EXPECT_LE(test::distance(Kd.get(), difference.get()), 1e-8 * test::norm(Kd.get()));
  }
}

// Rows and columns of slaves hold the diagonal alone; what slaves have in y changes nothing.
TEST_P(Constrained, SlavesAreOutOfTheEquation) {
  const auto slaves = equation_.make_vector();
  {
    const ArrayView entries(slaves.get());
    for (std::size_t i = 0; i < body_.map().is_slave().size(); ++i) {
      entries.span()[i] = body_.map().is_slave()[i] ? 1.0 : 0.0;
    }
  }
  ASSERT_GT(test::norm(slaves.get()), 5.0);
  EXPECT_EQ(value(0.0, slaves.get()), value(1.0, slaves.get()));
  EXPECT_EQ(test::dot(gradient(0.0, slaves.get()).get(), slaves.get()), 0.0);
  const Handle<Mat> K = equation_.make_hessian();
  equation_.hessian(y_.get(), K.get(), Projection::none);
  const Handle<Vec> column = equation_.make_vector();
  check(MatMult(K.get(), slaves.get(), column.get()));
  const ConstArrayView k(column.get()), s(slaves.get());
  double diagonal = 0.0;
  for (std::size_t i = 0; i < k.span().size(); ++i) {
    if (s.span()[i] == 0.0) {
      EXPECT_EQ(k.span()[i], 0.0);
    } else {
      diagonal = k.span()[i];
      EXPECT_GT(diagonal, 0.0);
    }
  }
}

TEST_P(Constrained, NearNullSpaceHoldsWhatIsFree) {
  if (GetParam().name.ends_with("WithPressures")) return;  // no multigrid

  const Handle<Mat> K = equation_.make_hessian();
  MatNullSpace space = nullptr;
  check(MatGetNearNullSpace(K.get(), &space));
  ASSERT_NE(space, nullptr);
  PetscInt num_modes = 0;
  const Vec* modes = nullptr;
  check(MatNullSpaceGetVecs(space, nullptr, &num_modes, &modes));
  // Fewer where nothing but a mechanism of 5 degrees of freedom is there.
  EXPECT_EQ(num_modes, GetParam().name.starts_with("Mechanism") && GetParam().order == 1 ? 5 : 6);
  for (PetscInt m = 0; m < num_modes; ++m) {
    const ConstArrayView mode(modes[m]);
    for (std::size_t i = 0; i < mode.span().size(); ++i) {
      const bool is_out = equation_.prescribed()[i] != 0;
      EXPECT_TRUE(!is_out || mode.span()[i] == 0.0);
    }
  }
}

}  // namespace
}  // namespace pliant::test_constrained_equation
