// The solver in trouble, and where it stops.
#include "base/limits.hpp"
#include "solver/newton.hpp"
#include "solver/on_cubes.hpp"

#include <limits>

namespace pliant::test_newton {
namespace {

using test::Field;
using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;
class Newton : public test::OnCubes {};

// The benchmark of stiff bodies: E = 1 GPa, almost incompressible, long steps.
TEST_F(Newton, AStiffBodyTakesFewIterations) {
  for (const auto* name : {"saint-venant-kirchhoff", "neo-hookean"}) {
    ProblemSpec spec = clamped(make_law(name, 1e9, 0.45));
    spec.density = 1000.0;
    spec.loads = [](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> loads;
      loads.push_back(solid.gravity(1000.0, {Expression(), Expression(), Expression(-9.81)}));
      return loads;
    };
    Problem problem(comm, mesh(8), spec);
    const double dt = 0.025;
    auto q = problem.solid().vector(test::at_rest), v = problem.solid().vector(test::at_rest);
    for (int step = 1; step <= 3; ++step) {
      const auto q0 = test::moved(q.get(), 0.0, q.get()), v0 = test::moved(v.get(), 0.0, v.get());
      const auto report = problem.solve(step * dt, dt, q0, v0, q);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
      EXPECT_LE(report.newton_iterations, 4);
      check(VecWAXPY(v.get(), -1.0, q0.get(), q.get()));
      check(VecScale(v.get(), 1.0 / dt));
    }
    EXPECT_EQ(problem.statistics().backtracks, 0);
    EXPECT_EQ(problem.statistics().rounding_stops, 0);
    EXPECT_GT(test::norm(q.get()), 1e-6);
  }
}

// A start pressed to half its size: Hessians there are indefinite; the fallback sequence brings the body back to rest.
// St. Venant-Kirchhoff's law has other equilibria there, and is pressed less.
TEST_F(Newton, ACompressedStartConvergesOnProjectedHessians) {
  for (const auto kind : {LinearKind::cholesky, LinearKind::amg}) {
    for (const auto& [name, part] : {std::pair{"saint-venant-kirchhoff", 0.7}, std::pair{"neo-hookean", 1.0}}) {
      ProblemSpec spec = clamped(make_law(name, 1e6, 0.3));
      spec.newton.relative = 1e-10;
      spec.linear = kind;
      Problem problem(comm, mesh(3), spec);
      const auto start = problem.solid().vector([s = part](const Point& x) {
        return Point{-0.4 * s * x[0], -0.3 * s * x[0] * (x[1] - 0.5) + 0.03 * x[0] * test::rough(x, 1, 1),
                     -0.3 * s * x[0] * (x[2] - 0.5)};
      });
      const auto v0 = problem.solid().vector(test::at_rest), q = problem.solid().vector(test::at_rest);
      const auto report = problem.solve(1.0, 1.0, start, v0, q);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << name << ": " << report.reason;
      EXPECT_GT(problem.statistics().projections, 0) << name;
      EXPECT_LE(test::deviation(problem.solid(), q.get(), test::at_rest), 1e-8) << name;
      expect_same_everywhere(report);
    }
  }
}

// A push that a full Newton step answers by turning cells inside out.
TEST_F(Newton, StepsThatWouldInvertAreCapped) {
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e5, 0.3));
  spec.loads = traction(-4e5, 0.0, 0.0);
  Problem problem(comm, mesh(3), spec);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_GT(problem.statistics().capped_steps, 0);
  EXPECT_TRUE(std::isfinite(problem.strain_energy(q.get())));
  EXPECT_LT(test::norm(problem.reactions(q.get()).get()), 1e7);
  double lowest = infinity;
  problem.elastic().stresses({.q = test::local_values(q.get())},
                             [&](PetscInt, const CellStress& s) { lowest = std::min(lowest, s.volume_ratio); });
  lowest = minimum(comm, lowest);
  EXPECT_GT(lowest, 0.0);
  EXPECT_LT(lowest, 0.6);
}

/// -strength ln(1 - u_x / limit) at every node: a wall that no step bound announces. Beyond it the value is what the
/// test says (infinity or NaN).
class Wall final : public EnergyTerm {
 public:
  Wall(const Solid& solid, double beyond) : size_(solid.layout().num_owned_nodes), beyond_(beyond) {
    for (PetscInt a = 0; a < size_; ++a) blocks_.push_back(solid.pattern().block(a, a));
  }
  std::string_view name() const override { return "wall"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage& stage, std::span<const double> q) const override {
    double total = 0.0;
    for (PetscInt a = 0; a < size_; ++a) {
      if (q[3 * a] >= limit) return beyond_;
      total -= strength * (std::log1p(-q[3 * a] / limit) - std::log1p(-stage.q0[3 * a] / limit));
    }
    return total;
  }
  void add_gradient(const LocalStage&, std::span<const double> q, std::span<double> r) const override {
    for (PetscInt a = 0; a < size_; ++a) r[3 * a] += strength / (limit - q[3 * a]);
  }
  void add_hessian(const LocalStage&, std::span<const double> q, const BlockWriter& K, Projection) const override {
    for (PetscInt a = 0; a < size_; ++a) K.block(a, blocks_[a]).values[0] += strength / std::pow(limit - q[3 * a], 2);
  }
  static constexpr double limit = 0.05, strength = 1.0;

 private:
  PetscInt size_;
  double beyond_;
  std::vector<std::int32_t> blocks_;
};

TEST_F(Newton, InfinityAndNanMakeItBacktrack) {
  for (const double beyond : {infinity, std::numeric_limits<double>::quiet_NaN(), -infinity}) {
    ProblemSpec spec = clamped(make_law("linear", 1e5, 0.3));
    spec.loads = [=](const Solid& solid) {
      auto terms = with_term<Wall>(beyond)(solid);
      terms.push_back(solid.traction({Expression(2e4), Expression(), Expression()}));
      return terms;
    };
    Problem problem(comm, mesh(3), spec);
    const auto q = problem.solid().vector(test::at_rest);
    const auto report = problem.solve_static(q);
    ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    EXPECT_GT(problem.statistics().backtracks, 0);
    double furthest = 0.0;
    {
      const ConstArrayView u(q.get());
      for (PetscInt a = 0; a < problem.solid().layout().num_owned_nodes; ++a) furthest = std::max(furthest, u[3 * a]);
    }
    furthest = maximum(comm, furthest);
    EXPECT_LT(furthest, Wall::limit);
    EXPECT_GT(furthest, 0.5 * Wall::limit);
    expect_same_everywhere(report);
  }
}

/// force |u_x - rest| at every node, smooth within `width` of rest, as regularized friction is (Li et al. 2020,
/// "Incremental potential contact", eq. 19): no second derivative tells from outside where the force changes its sign.
class Drag final : public EnergyTerm {
 public:
  explicit Drag(const Solid& solid) : size_(solid.layout().num_owned_nodes) {
    for (PetscInt a = 0; a < size_; ++a) blocks_.push_back(solid.pattern().block(a, a));
  }
  std::string_view name() const override { return "drag"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage&, std::span<const double> q) const override {
    double total = 0.0;
    for (PetscInt a = 0; a < size_; ++a) {
      const double y = std::abs(q[3 * a] - rest);
      total += force * (y < width ? y * y / width - y * y * y / (3 * width * width) + width / 3 : y);
    }
    return total;
  }
  void add_gradient(const LocalStage&, std::span<const double> q, std::span<double> r) const override {
    for (PetscInt a = 0; a < size_; ++a) {
      const double s = (q[3 * a] - rest) / width, inside = s * (2 - std::abs(s));
      r[3 * a] += force * (std::abs(s) < 1 ? inside : std::copysign(1.0, s));
    }
  }
  void add_hessian(const LocalStage&, std::span<const double> q, const BlockWriter& K, Projection) const override {
    for (PetscInt a = 0; a < size_; ++a) {
      const double s = std::abs(q[3 * a] - rest) / width;
      if (s < 1) K.block(a, blocks_[a]).values[0] += force / width * (2 - 2 * s);
    }
  }
  static constexpr double rest = 1e-3, width = 1e-5, force = 20.0;

 private:
  PetscInt size_;
  std::vector<std::int32_t> blocks_;
};

TEST_F(Newton, WhereAForceChangesItsSignItDoesNotGoToAndFro) {
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e5, 0.3));
  spec.loads = with_term<Drag>();
  Problem problem(comm, mesh(3), spec);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_LE(report.newton_iterations, 35);  // else more than 50
  expect_same_everywhere(report);
}

TEST_F(Newton, CholeskyAndMultigridAgree) {
  const auto file = mesh(4, Shape::jittered);
  constexpr std::array<std::pair<int, LinearKind>, 5> kinds{{{1, LinearKind::amg},
                                                             {2, LinearKind::amg},
                                                             {2, LinearKind::p_multigrid},
                                                             {1, LinearKind::adaptive},
                                                             {2, LinearKind::adaptive}}};
  for (const auto& [order, multigrid] : kinds) {
    std::array<Handle<Vec>, 2> q;
    std::array<std::unique_ptr<Problem>, 2> problems;
    for (const int i : {0, 1}) {
      ProblemSpec spec = clamped(make_law("neo-hookean", 1e6, 0.4));
      spec.order = order;
      spec.newton.relative = 1e-11;
      spec.linear = i == 0 ? LinearKind::cholesky : multigrid;
      spec.loads = traction(1e5, 2e4, -5e4);
      problems[i] = std::make_unique<Problem>(comm, file, spec);
      q[i] = problems[i]->solid().vector(test::at_rest);
      const auto report = problems[i]->solve_static(q[i]);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    }
    EXPECT_LE(test::distance(q[0].get(), q[1].get()), 1e-7 * test::norm(q[0].get()));
  }
}

// Nothing asked for but zero: it stops where rounding begins, and says so.
TEST_F(Newton, StopsAtTheRoundingFloor) {
  for (const auto* name : {"linear", "saint-venant-kirchhoff", "neo-hookean"}) {
    for (const int order : {1, 2}) {
      ProblemSpec spec = clamped(make_law(name, 1e9, 0.45));
      spec.order = order;
      spec.newton.relative = 0.0;
      spec.loads = traction(1e7, 0.0, 2e6);
      Problem problem(comm, mesh(3), spec);
      const auto q = problem.solid().vector(test::at_rest);
      const auto report = problem.solve_static(q);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << name << order << ": " << report.reason;
      EXPECT_EQ(problem.statistics().rounding_stops, 1);
      EXPECT_LE(report.newton_iterations, 8);
      const Handle<Vec> r = problem.potential().make_vector();
      problem.potential().gradient(q.get(), r.get());
      EXPECT_LE(test::norm(r.get()), 1e-12 * problem.potential().force_scale(q.get()));
    }
  }
}

// A body under a large constant load whose load grows a little: the energies compared are differences from the start,
// beside which the strain energy itself is larger by 1e12 and more.
TEST_F(Newton, SmallLoadIncrementsOnAPrestressedBodyConverge) {
  for (const auto* name : {"saint-venant-kirchhoff", "neo-hookean"}) {
    for (const double growth : {1e-2, 1e-4, 1e-6, 1e-8}) {
      ProblemSpec spec = clamped(make_law(name, 1e6, 0.3));
      spec.newton.relative = 1e-12;
      spec.loads = traction(2e5, 0.0, 3e4);
      Problem problem(comm, mesh(3), spec);
      const auto v0 = problem.solid().vector(test::at_rest), q = problem.solid().vector(test::at_rest);
      ASSERT_EQ(problem.solve_static(q).outcome, StageOutcome::converged);
      const auto q0 = test::moved(q.get(), 0.0, q.get());
      const auto before = problem.statistics();
      const auto report = problem.solve(2.0, 1.0, q0, v0, q, 1.0 + growth);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << name << " " << growth << ": " << report.reason;
      EXPECT_LE(report.newton_iterations, 4) << growth;
      EXPECT_EQ(problem.statistics().backtracks - before.backtracks, 0) << name << " " << growth;
      EXPECT_EQ(problem.statistics().projections - before.projections, 0) << name << " " << growth;
      const double moved = test::distance(q.get(), q0.get());
      EXPECT_GT(moved, 0.1 * growth * test::norm(q0.get()));
      EXPECT_LT(moved, 10.0 * growth * test::norm(q0.get()));
    }
  }
}

// The same in motion: a body at rest in its strained state, and a step in which almost nothing happens.
TEST_F(Newton, ShortStepsOfAPrestressedBodyConverge) {
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e6, 0.3));
  spec.newton.relative = 1e-12;
  spec.loads = traction(2e5, 0.0, 3e4);
  Problem still(comm, mesh(3), spec);
  const auto q0 = still.solid().vector(test::at_rest);
  ASSERT_EQ(still.solve_static(q0).outcome, StageOutcome::converged);
  spec.density = 1000.0;
  spec.newton.relative = 1e-8;
  Problem moving(comm, mesh(3), spec);
  const auto q = moving.solid().vector(test::at_rest);
  for (const double dt : {1e-2, 1e-4, 1e-6}) {
    for (const double speed : {0.0, 1e-6, 1.0}) {
      const auto v0 = moving.solid().vector([=](const Point& x) { return Point{0.0, speed * x[0], 0.0}; });
      const auto start = test::moved(q0.get(), 0.0, q0.get());
      const auto report = moving.solve(1.0, dt, start, v0, q, 1.0);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << dt << " " << speed << ": " << report.reason;
      EXPECT_LE(report.newton_iterations, 4) << dt << " " << speed;
    }
  }
  EXPECT_EQ(moving.statistics().backtracks, 0);
}

// Nothing to do: no forces at all, or the solution already there.
TEST_F(Newton, ABodyAtRestTakesNoIteration) {
  Problem problem(comm, mesh(2), clamped(make_law("neo-hookean", 1e6, 0.3)));
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  EXPECT_EQ(report.outcome, StageOutcome::converged);
  EXPECT_EQ(report.newton_iterations, 0);
  EXPECT_EQ(test::norm(q.get()), 0.0);
}

// Free fall: the guess q0 + dt v0 - dt^2 g is not far, and the body is not strained by it.
TEST_F(Newton, FreeFallIsExact) {
  ProblemSpec spec;
  spec.law = make_law("neo-hookean", 1e6, 0.3);
  spec.density = 1000.0;
  spec.loads = [](const Solid& solid) {
    std::vector<std::unique_ptr<EnergyTerm>> loads;
    loads.push_back(solid.gravity(1000.0, {Expression(), Expression(), Expression(-9.81)}));
    return loads;
  };
  Problem problem(comm, mesh(2), spec);
  const auto q0 = problem.solid().vector([](const Point&) { return Point{0.0, 0.0, 100.0}; });
  const auto v0 = problem.solid().vector([](const Point&) { return Point{3.0, 0.0, -20.0}; });
  const auto q = problem.solid().vector(test::at_rest);
  const double dt = 0.1;
  const auto report = problem.solve(dt, dt, q0, v0, q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_LE(report.newton_iterations, 2);
  const Field exact = [=](const Point&) { return Point{3.0 * dt, 0.0, 100.0 - 20.0 * dt - 9.81 * dt * dt}; };
  EXPECT_LE(test::deviation(problem.solid(), q.get(), exact), 1e-9);
}

// A tumbling body strains little, and its stiffness rotates with it: so does the factorization.
TEST_F(Newton, AKeptFactorizationRotatesWithTheBody) {
  std::map<bool, double> work;  // in linear iterations, of which a factorization of so few unknowns costs eight
  for (const bool turns : {true, false}) {
    check(PetscOptionsSetValue(nullptr, "-newton_turn_factor", turns ? "true" : "false"));
    ProblemSpec spec;
    spec.law = make_law("neo-hookean", 1e7, 0.3);
    spec.density = 1000.0;
    Problem problem(comm, mesh(3), spec);
    // About the z axis through the middle, by 0.2 rad each step.
    const double dt = 0.01, spin = 20.0;
    const auto q = problem.solid().vector(test::at_rest), q0 = problem.solid().vector(test::at_rest);
    const auto v = problem.solid().vector([&](const Point& X) -> Point {
      return {-spin * (X[1] - 0.5), spin * (X[0] - 0.5), 0.0};
    });
    for (int step = 1; step <= 10; ++step) {
      const auto report = problem.solve(step * dt, dt, q0, v, q);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
      check(VecWAXPY(v.get(), -1.0, q0.get(), q.get()));
      check(VecScale(v.get(), 1.0 / dt));
      check(VecCopy(q.get(), q0.get()));
    }
    work[turns] = static_cast<double>(problem.statistics().linear_iterations + 8 * problem.statistics().factorizations);
    check(PetscOptionsClearValue(nullptr, "-newton_turn_factor"));
  }
  EXPECT_LT(work[true], 0.7 * work[false]);
}

/// No force at all: it counts its Hessians.
class Counter final : public EnergyTerm {
 public:
  Counter(const Solid&, int* number) : number_(number) {}
  std::string_view name() const override { return "counter"; }
  TermDeclaration declaration() const override { return {.account = Account::load}; }
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage&, std::span<const double>, std::span<double>) const override {}
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter&, Projection) const override {
    ++*number_;
  }

 private:
  int* number_;
};

// Near the solution the Hessian of the iterate before is as good as a new one, however far a stage is solved.
TEST_F(Newton, TheLastStepNeedsNoNewHessian) {
  const double dt = 0.01, speed = 3.0;
  std::map<double, Handle<Vec>> ends;
  for (const double relative : {1e-6, 1e-11}) {
    int num_hessians = 0;
    ProblemSpec spec = clamped(make_law("neo-hookean", 1e5, 0.3));
    spec.density = 1000.0;
    spec.newton.relative = relative;
    spec.loads = with_term<Counter>(&num_hessians);
    Problem problem(comm, mesh(3), spec);
    auto& q = ends[relative];
    q = problem.solid().vector(test::at_rest);
    const auto q0 = problem.solid().vector(test::at_rest);
    const auto v = problem.solid().vector([&](const Point& X) { return Point{0.0, 0.0, speed * X[0]}; });
    int num_iterations = 0;
    for (int step = 1; step <= 10; ++step) {
      const auto report = problem.solve(step * dt, dt, q0, v, q);
      ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
      num_iterations += report.newton_iterations;
      check(VecWAXPY(v.get(), -1.0, q0.get(), q.get()));
      check(VecScale(v.get(), 1.0 / dt));
      check(VecCopy(q.get(), q0.get()));
    }
    EXPECT_LE(num_hessians, 0.8 * num_iterations);
  }
  const double size = test::norm(ends[1e-11].get());
  check(VecAXPY(ends[1e-6].get(), -1.0, ends[1e-11].get()));
  EXPECT_GT(size, 0.1);
  EXPECT_LE(test::norm(ends[1e-6].get()), 1e-5 * size);
}

}  // namespace
}  // namespace pliant::test_newton
