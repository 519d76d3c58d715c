// The equations of joints, and what a mechanism makes of them.
#include "energy/constraint/mechanism.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "time/stage.hpp"

#include <cmath>
#include <eigen3/Eigen/SVD>
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

/// The motion with one of its twelve numbers moved.
template <class T>
BodyMotion<T> moved(BodyMotion<T> motion, std::size_t number, const T& by) {
  T& x = number < 3 ? motion.translation[number] : motion.gradient.a[number - 3];
  x = x + by;
  return motion;
}

double component(const MotionForce& force, std::size_t number) {
  return force.along(moved(BodyMotion<double>{}, number, 1.0));
}

// Equations are polynomials of the second degree: central differences are their derivatives, but for rounding.
TEST(JointEquations, GradientsAreTheirDerivatives) {
  const TimeSeries<double> given(0.4, -0.7, 1.3);
  const auto a = motion(0.4, 0.3), b = motion(0.4, 1.1);
  for (const JointEquation& equation : one_of_each()) {
    const auto gradient = equation.gradient({&a, &b}, given);
    for (std::size_t k = 0; k < 12; ++k) {
      const double of_a = equation(moved(a, k, 0.5), b, given) - equation(moved(a, k, -0.5), b, given);
      const double of_b = equation(a, moved(b, k, 0.5), given) - equation(a, moved(b, k, -0.5), given);
      EXPECT_NEAR(component(gradient[0], k), of_a, 1e-14) << equation.kind.index() << " " << k;
      EXPECT_NEAR(component(gradient[1], k), of_b, 1e-14) << equation.kind.index() << " " << k;
    }
  }
}

TEST(JointEquations, GradientsChangeWithTheMotions) {
  const TimeSeries<double> given(0.4, -0.7, 1.3);
  const auto a = motion(0.4, 0.3), b = motion(0.4, 1.1);
  auto da = motion(0.7, 0.2), db = motion(0.2, 0.9);
  da.centre = a.centre;
  db.centre = b.centre;
  const auto a_moved = sum_of(1.0, a, da), b_moved = sum_of(1.0, b, db);
  for (const JointEquation& equation : one_of_each()) {
    const auto before = equation.gradient({&a, &b}, given), after = equation.gradient({&a_moved, &b_moved}, given);
    const auto change = equation.change_of_gradient({&da, &db}, given);
    for (std::size_t side = 0; side < 2; ++side) {
      for (std::size_t k = 0; k < 12; ++k) {
        EXPECT_NEAR(component(change[side], k), component(after[side], k) - component(before[side], k), 1e-14)
            << equation.kind.index() << " " << k;
      }
    }
  }
}

TEST(JointEquations, GradientsOfAccelerationsAreTheirDerivatives) {
  const TimeSeries<double> given(0.4, -0.7, 1.3);
  const auto a = series(0.4, 0.3), b = series(0.4, 1.1);
  const auto sum = [](const BodyMotion<TimeSeries<double>>& x, double rate, double acceleration) {
    BodyMotion<double> result{x.centre, {}, {}};
    const auto of = [&](const TimeSeries<double>& s) {
      return s.value + rate * s.rate + acceleration * s.acceleration;
    };
    for (std::size_t i = 0; i < 3; ++i) result.translation[i] = of(x.translation[i]);
    for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = of(x.gradient.a[i]);
    return result;
  };
  const std::array values{sum(a, 0.0, 0.0), sum(b, 0.0, 0.0)}, once{sum(a, 1.0, 0.0), sum(b, 1.0, 0.0)},
      twice{sum(a, 2.0, 1.0), sum(b, 2.0, 1.0)};
  const TimeSeries<double> more(0.5, 0.5, 0.5), less(-0.5, -0.5, -0.5);
  for (const JointEquation& equation : one_of_each()) {
    const auto gradient = equation.gradient_of_acceleration({&values[0], &values[1]}, {&once[0], &once[1]},
                                                            {&twice[0], &twice[1]}, given);
    for (std::size_t k = 0; k < 12; ++k) {
      const auto of_a = equation(moved(a, k, more), b, given) - equation(moved(a, k, less), b, given);
      const auto of_b = equation(a, moved(b, k, more), given) - equation(a, moved(b, k, less), given);
      EXPECT_NEAR(component(gradient[0], k), of_a.acceleration, 1e-13) << equation.kind.index() << " " << k;
      EXPECT_NEAR(component(gradient[1], k), of_b.acceleration, 1e-13) << equation.kind.index() << " " << k;
    }
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
  Mechanism make(std::vector<JointEquation> equations, const std::vector<char>& are_held = {0, 0}) const {
    std::vector<std::unique_ptr<RigidPart>> parts;
    for (const bool is_first : {true, false}) parts.push_back(slab(is_first));
    return {solid_.layout(), std::move(parts), are_held, std::move(equations)};
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
  EXPECT_TRUE(make(equations).dependent_joints().joints.empty());
  // A line between two points of bodies that turn about their middle is no constraint of its own length alone: a third
  // ball closes a loop that cannot move, and a fourth repeats it.
  for (auto& e : ball({ground, 1}, {1.0, 0.5, 0.5}, 2)) equations.push_back(e);
  const auto [joints, number] = make(equations).dependent_joints();
  EXPECT_EQ(joints, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(number, 1);
}

/// The kinds of stages that a mechanism knows.
struct StageKind {
  Rigidity rigidity;
  double end_weight;
  bool is_held;  // the first part
};

// Columns are the derivatives of displacements, and curvatures those of the work of forces along virtual ones.
TEST_F(Mechanisms, HaveExactDerivatives) {
  for (const StageKind kind :
       {StageKind{Rigidity::of_configurations, 0.0, false}, StageKind{Rigidity::of_accelerations, 0.0, false},
        StageKind{Rigidity::of_accelerations, 1.3, false}, StageKind{Rigidity::of_configurations, 0.0, true},
        StageKind{Rigidity::of_accelerations, 1.3, true}}) {
    auto equations = ball({ground, 0}, {0.0, 0.5, 0.5}, 0);
    equations.push_back({Turn{unit_vector(0), unit_vector(1), Expression("0.3*t")}, {ground, 0}, 0});
    equations.push_back({Distance{{0.2, 0.1, 0.3}, {0.9, 0.8, 0.4}, 1.0, Expression("0.05*t")}, {0, 1}, 1});
    equations.push_back({Perpendicularity{unit_vector(0), {0.0, 0.6, 0.8}}, {0, 1}, 2});
    Mechanism mechanism = make(std::move(equations), {static_cast<char>(kind.is_held), 0});
    mechanism.set_rigidity(kind.rigidity);
    const auto q = solid_.vector([](const Point& x) { return 0.02 * test::strained(x); });
    const auto v = solid_.vector([](const Point& x) { return 0.2 * test::strained(x); });
    StagePoint stage;
    stage.time = stage.end_time = stage.dt = 0.05;
    stage.q0 = q.get();
    stage.v0 = v.get();
    stage.end_weight = kind.end_weight;
    mechanism.begin_stage(stage, q.get());
    const std::size_t n = mechanism.num_degrees_of_freedom();
    ASSERT_EQ(n, 6u);
    std::vector<double> y{0.01, -0.02, 0.015, 0.005, -0.01, 0.02};
    const auto f = solid_.vector(test::rough_field(1.0, 5));
    const auto work = [&](std::span<const double> at, std::size_t k) {
      double sum = 0.0;
      std::vector<Vector3<double>> columns(n);
      const ConstArrayView forces(f.get());
      for (const PetscInt a : mechanism.nodes()) {
        mechanism.put_test_columns(at, a, columns);
        for (PetscInt i = 0; i < 3; ++i) sum += forces[3 * a + i] * columns[k][static_cast<std::size_t>(i)];
      }
      return sum;
    };
    {
      const Handle<Vec> there = make_vector(solid_.layout());
      mechanism.put_displacements(y, there.get());
      const auto found = mechanism.nearest_unknowns(there.get());
      for (std::size_t k = 0; k < n && kind.end_weight == 0.0; ++k) EXPECT_NEAR(found[k], y[k], 1e-12) << k;
    }
    constexpr double h = 1e-4;
    const auto curvature = mechanism.curvature(y, f.get());
    for (std::size_t l = 0; l < n; ++l) {
      auto more = y, less = y;
      more[l] += h;
      less[l] -= h;
      const Handle<Vec> above = make_vector(solid_.layout()), below = make_vector(solid_.layout());
      mechanism.put_displacements(more, above.get());
      mechanism.put_displacements(less, below.get());
      {
        const ConstArrayView u(above.get()), w(below.get());
        std::vector<Vector3<double>> columns(n);
        for (const PetscInt a : mechanism.nodes()) {
          mechanism.put_columns(y, a, columns);
          for (PetscInt i = 0; i < 3; ++i) {
            EXPECT_NEAR(columns[l][static_cast<std::size_t>(i)], (u[3 * a + i] - w[3 * a + i]) / (2.0 * h), 1e-6);
          }
        }
      }
      for (std::size_t k = 0; k < n; ++k) {
        EXPECT_NEAR(curvature[n * k + l], (work(more, k) - work(less, k)) / (2.0 * h), 1e-5) << k << " " << l;
      }
    }
  }
}

// A body that hangs on a hinge turns by a finite angle, and the one that carries the hinge stays where it is, if soft
// bodies hold it.
TEST_F(Mechanisms, LeaveHeldPartsWhereTheyAre) {
  for (const bool is_held : {false, true}) {
    auto equations = ball({0, 1}, {0.5, 0.5, 0.5}, 0);
    for (const std::size_t e : {0, 2})
      equations.push_back({Perpendicularity{unit_vector(1), unit_vector(e)}, {0, 1}, 0});
    Mechanism mechanism = make(std::move(equations), {static_cast<char>(is_held), 0});
    const Handle<Vec> q = make_vector(solid_.layout());
    StagePoint stage;
    stage.time = stage.dt = 0.05;
    mechanism.begin_stage(stage, q.get());
    const std::size_t n = mechanism.num_degrees_of_freedom();
    ASSERT_EQ(n, 7u);
    const std::unique_ptr<RigidPart> first = slab(true);
    const std::span<const PetscInt> nodes = first->nodes();
    std::vector<double> rows;  // of the first body's displacements, by all unknowns
    std::vector<Vector3<double>> columns(n);
    for (const PetscInt a : nodes) {
      mechanism.put_columns(std::vector<double>(n, 0.0), a, columns);
      for (std::size_t i = 0; i < 3; ++i) {
        for (const auto& column : columns) rows.push_back(column[i]);
      }
    }
    const std::vector<double> all = gathered(comm, rows);
    const auto width = static_cast<Eigen::Index>(n);
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> moved(
        all.data(), static_cast<Eigen::Index>(all.size()) / width, width);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(moved, Eigen::ComputeFullV);
    const Eigen::VectorXd swing = 0.3 * svd.matrixV().col(width - 1);
    const std::vector<double> y(swing.begin(), swing.end());
    ASSERT_LT(svd.singularValues()[width - 1], 1e-12);
    EXPECT_GT(mechanism.rotation(y), 0.2);
    mechanism.put_displacements(y, q.get());
    const ConstArrayView u(q.get());
    double largest = 0.0;
    for (const PetscInt a : nodes) {
      for (PetscInt i = 0; i < 3; ++i) largest = std::max(largest, std::abs(u[3 * a + i]));
    }
    largest = maximum(comm, largest);
    if (is_held) {
      EXPECT_LT(largest, 1e-5);
    } else {
      EXPECT_GT(largest, 1e-3);
    }
  }
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
