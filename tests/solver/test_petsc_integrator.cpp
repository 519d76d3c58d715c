// PETSc's integrators against our own and against what theory says of them.
#include "petsc/memory_archive.hpp"
#include "solver/petsc_integrator.hpp"
#include "solver/problem.hpp"
#include "time/integrator.hpp"

#include <functional>

#include <fmt/format.h>

namespace pliant::test_petsc_integrator {
namespace {

using test::distance;
using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Nodal forces -c (1 + |v|^2) v: a friction whose rate is that of the stage, to see what becomes of velocities.
class Drag final : public EnergyTerm {
 public:
  explicit Drag(const Solid& solid) : size_(solid.layout().num_owned_nodes) {
    for (PetscInt a = 0; a < size_; ++a) blocks_.push_back(solid.pattern().block(a, a));
  }
  std::string_view name() const override { return "drag"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage& stage, std::span<const double> q) const override {
    double total = 0.0;
    for (PetscInt a = 0; a < size_; ++a) {
      const double square = norm2(velocity(stage, q, a));
      total += stage.dt * c * (square / 2 + square * square / 4);
    }
    return total;
  }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    for (PetscInt a = 0; a < size_; ++a) {
      const Point v = velocity(stage, q, a);
      for (int i = 0; i < 3; ++i) r[3 * a + i] += c * (1.0 + norm2(v)) * v[i];
    }
  }
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection) const override {
    for (PetscInt a = 0; a < size_; ++a) {
      const Point v = velocity(stage, q, a);
      const auto block = K.block(a, blocks_[a]);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          block.values[i * block.stride + j] += c / stage.dt * ((i == j ? 1.0 + norm2(v) : 0.0) + 2.0 * v[i] * v[j]);
        }
      }
    }
  }

 private:
  static constexpr double c = 20.0;  // [kg/s]
  static double norm2(const Point& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }
  static Point velocity(const LocalStage& stage, std::span<const double> q, PetscInt a) {
    Point v{};
    for (int i = 0; i < 3; ++i) v[i] = (q[3 * a + i] - stage.q0[3 * a + i]) / stage.dt;
    return v;
  }
  PetscInt size_;
  std::vector<std::int32_t> blocks_;
};

/// Bit by bit.
bool equal(Vec a, Vec b) {
  PetscBool result = PETSC_FALSE;
  check(VecEqual(a, b, &result));
  return result;
}

class PetscIntegration : public ::testing::Test {
 protected:
  /// A soft, viscous block, shaken at one end along x, heavy, in drag; waves take about half a second through it. The
  /// shaking carries its velocity and acceleration into the body. After 5 s the end is pushed through the block.
  Problem& problem() {
    if (!problem_) problem_ = std::make_unique<Problem>(on_, mesh(), spec());
    return *problem_;
  }
  /// From now on every rank has the problem to itself.
  void work_alone() {
    on_ = MPI_COMM_SELF;
    problem_.reset();
  }
  ProblemSpec spec() const {
    ProblemSpec spec;
    spec.law = make_law("neo-hookean", 3e3, 0.3);
    spec.density = 1000.0;
    spec.supports = {
        {test::face(0, 0.0), {Expression("t > 5 ? 1.5 : 0.1*(1-cos(12*t))"), std::nullopt, Expression(0.0)}}};
    spec.loads = [](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> terms;
      terms.push_back(solid.gravity(1000.0, {Expression(), Expression("-3*sin(5*t)"), Expression(-2.0)}));
      terms.push_back(std::make_unique<Drag>(solid));
      terms.push_back(solid.viscous(WithStrainRate{KelvinVoigt{.shear = 10.0, .bulk = 20.0}, StrainRate::exact}));
      return terms;
    };
    spec.newton.relative = 1e-11;  // far below the errors of the steps
    return spec;
  }
  std::string mesh() const {
    return scratch_.file("cube.msh", [](const std::string& f) { test::write_body(f, {1, Shape::straight, 2}); });
  }
  State initial() {
    const auto q = problem().solid().vector(test::at_rest);
    const auto v = problem().solid().vector([](const Point& x) { return Point{0.0, 0.4 * x[0], -0.3 * x[0] * x[1]}; });
    return State(StateView{0.0, q.get(), v.get()});
  }
  PetscIntegratorOptions options_of(const PetscMethod& method) {
    return {.method = method, .newton = spec().newton, .linear = LinearKind::cholesky};
  }
  std::unique_ptr<PetscIntegrator> petsc(const PetscMethod& method) {
    const State start = initial();
    return std::make_unique<PetscIntegrator>(options_of(method), problem().potential(), problem().motion(),
                                             start.view());
  }
  std::unique_ptr<Integrator> own(std::string_view method) {
    const State start = initial();
    return std::make_unique<Integrator>(IntegratorOptions{.method = *find_method(method), .startup = Startup::dirk33},
                                        problem().system(), start.view());
  }
  /// The motion at `end` by our own method of third order, on each rank alone; found once.
  const State& reference() {
    if (on_ == comm) work_alone();
    if (!known) known = run(*own("dirk33"), 240, end);
    return *known;
  }
  static void TearDownTestSuite() { known.reset(); }  // as long as PETSc is there
  template <class AnyIntegrator>
  static void step(AnyIntegrator& integrator, const Step& to) {
    const StepAttempt attempt = integrator.attempt(to);
    ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
    integrator.accept(attempt);
  }
  /// Steps of two lengths, so that every past state counts.
  static void step_by_number(PetscIntegrator& integrator, int n) {
    const double dt = n % 3 == 2 ? 0.008 : 0.01;
    step(integrator, {integrator.state().time + dt, dt});
  }
  /// What goes on from what was kept goes on as what it was kept of, bit by bit, and both as if nothing had been.
  void expect_continuation(const PetscMethod& method, int num_before) {
    const auto first = petsc(method), second = petsc(method), undisturbed = petsc(method);
    for (int n = 0; n < num_before; ++n) {
      step_by_number(*first, n);
      step_by_number(*undisturbed, n);
    }
    test::MemoryArchive archive;
    first->keep(archive);
    first->forget();
    archive.turn_round();
    second->keep(archive);
    for (int n = num_before; n < num_before + 4; ++n) {
      SCOPED_TRACE(fmt::format("{}, step {} after {}", method.name, n, num_before));
      // An attempt that comes to nothing takes none of the memory away.
      if (n == num_before) second->attempt({60.0, 60.0 - second->state().time});
      for (PetscIntegrator* integrator : {first.get(), second.get(), undisturbed.get()}) step_by_number(*integrator, n);
      EXPECT_TRUE(equal(first->state().q.get(), second->state().q.get()));
      EXPECT_TRUE(equal(first->state().v.get(), second->state().v.get()));
      // To the tolerance of Newton's method.
      const Vec v = undisturbed->state().v.get();
      EXPECT_LE(distance(first->state().v.get(), v), 1e-9 * test::norm(v));
    }
  }
  template <class AnyIntegrator>
  static State run(AnyIntegrator& integrator, int num_steps, double end) {
    const double dt = end / num_steps;
    for (int n = 1; n <= num_steps && !HasFatalFailure(); ++n) step(integrator, {n * dt, dt});
    return State(integrator.state().view());
  }

  static constexpr double end = 0.25;  // [s]

  static inline std::optional<State> known;
  Scratch scratch_{comm};
  MPI_Comm on_ = comm;
  std::unique_ptr<Problem> problem_;
};

/// Sets an option of PETSc for a scope.
class Option {
 public:
  Option(const std::string& name, const std::string& value) : name_(name) {
    check(PetscOptionsSetValue(nullptr, name.c_str(), value.c_str()));
  }
  ~Option() { (void)PetscOptionsClearValue(nullptr, name_.c_str()); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

 private:
  std::string name_;
};

const PetscMethod& method_of(PetscMethod::Kind kind) {
  for (const auto& method : petsc_methods()) {
    if (method.kind == kind) return method;
  }
  throw std::logic_error("no such method");
}

class EveryPetscMethod : public PetscIntegration, public ::testing::WithParamInterface<PetscMethod> {
 protected:
  /// Errors of q and v at the end.
  struct Errors {
    double q, v;
  };
  Errors error(int num_steps) {
    const State result = run(*petsc(GetParam()), num_steps, end);
    return {distance(result.q.get(), reference().q.get()), distance(result.v.get(), reference().v.get())};
  }
};

// With drag, loads that change in time and prescribed motion. The order does not
// depend on ranks: each has its own problem, for speed.
TEST_P(EveryPetscMethod, HasItsOrderInPositionAndVelocity) {
  reference();
  const Errors coarse = error(30), fine = error(60);
  EXPECT_NEAR(std::log2(coarse.q / fine.q), GetParam().order, 0.1);
  EXPECT_NEAR(std::log2(coarse.v / fine.v), GetParam().order, 0.1);
  // ... and the motion is not small.
  EXPECT_GT(test::norm(reference().v.get()), 1.0);
  EXPECT_LT(fine.v, 0.05 * test::norm(reference().v.get()));
}

TEST_P(EveryPetscMethod, DoesNotDependOnTheNumberOfRanks) {
  const auto shared = petsc(GetParam());
  for (int n = 1; n <= 3; ++n) step(*shared, {n * 0.01, 0.01});
  const auto together = std::move(problem_);
  work_alone();
  const auto alone = petsc(GetParam());
  for (int n = 1; n <= 3; ++n) step(*alone, {n * 0.01, 0.01});
  // The tolerance of Newton's method.
  const double size = test::norm(alone->state().v.get());
  EXPECT_LE(test::deviation(together->solid(), shared->state().v.get(),
                            test::by_place(problem().solid(), alone->state().v.get())),
            1e-9 * size);
}

// Every rank alone: a factorization by several ranks is not the same to the last bit each time.
TEST_P(EveryPetscMethod, AnAttemptThatIsNotAcceptedLeavesNoTrace) {
  work_alone();
  const double dt = 0.01;
  const auto straight = petsc(GetParam()), troubled = petsc(GetParam());
  for (int n = 1; n <= 4; ++n) {
    step(*straight, {n * dt, dt});
    const double t = (n - 1) * dt;
    // The end is pushed through the block, where numbers are not finite.
    const StepAttempt failed = troubled->attempt({60.0, 60.0 - t});
    EXPECT_EQ(failed.report.outcome, StageOutcome::retry);
    EXPECT_EQ(troubled->attempt({70.0, 70.0 - t}).report.outcome, StageOutcome::retry);
    EXPECT_EQ(troubled->attempt({t + dt / 2, dt / 2}).report.outcome, StageOutcome::converged);
    EXPECT_EQ(troubled->attempt({t + 2 * dt, 2 * dt}).report.outcome, StageOutcome::converged);
    step(*troubled, {n * dt, dt});
    EXPECT_TRUE(equal(troubled->state().q.get(), straight->state().q.get())) << "step " << n;
    EXPECT_TRUE(equal(troubled->state().v.get(), straight->state().v.get())) << "step " << n;
  }
}

TEST_P(EveryPetscMethod, GoesOnFromWhatWasKept) {
  work_alone();
  for (const int num_before : {0, 1, 2, 6}) expect_continuation(GetParam(), num_before);
}

// The end of the block that is pushed through belongs to some of the ranks only.
TEST_P(EveryPetscMethod, FailuresAreToldToAllRanks) {
  const auto integrator = petsc(GetParam());
  step(*integrator, {0.01, 0.01});
  const StepAttempt failed = integrator->attempt({60.0, 60.0 - 0.01});
  EXPECT_EQ(failed.report.outcome, StageOutcome::retry);
  EXPECT_FALSE(failed.report.reason.empty());
  EXPECT_EQ(broadcast(comm, failed.report.reason), failed.report.reason);
  step(*integrator, {0.02, 0.01});
}

// The last stage is in balance, but for what holds the support, and has the support's motion exactly.
TEST_P(EveryPetscMethod, TheLastStageHoldsTheReactions) {
  const auto integrator = petsc(GetParam());
  const double dt = 0.01;
  step(*integrator, {dt, dt});
  const StepAttempt attempt = integrator->attempt({2 * dt, dt});
  ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
  const double t = attempt.last_stage.time;
  EXPECT_NEAR(t, GetParam().kind == PetscMethod::Kind::alpha2 ? 1.5 * dt : 2 * dt, 1e-12);
  auto& potential = problem().potential();
  const auto r = potential.make_vector();
  potential.begin_stage(attempt.last_stage);
  potential.gradient_with_reactions(attempt.last_q, r.get());
  const auto& layout = problem().solid().layout();
  const ConstArrayView force(r.get()), q(attempt.last_q), a(attempt.last_a), q_end(attempt.q), v_end(attempt.v);
  double largest = 0.0, out_of_balance = 0.0;
  for (PetscInt k = 0; k < 3 * layout.num_owned_nodes; ++k) {
    double& part = potential.prescribed()[k] ? largest : out_of_balance;
    part = std::max(part, std::abs(force[k]));
    if (!potential.prescribed()[k] || k % 3 != 0) continue;
    // A formula's second derivative is a difference of fifth order over the stage, not to rounding; the others are.
    EXPECT_NEAR(q[k], 0.1 * (1.0 - std::cos(12.0 * t)), 1e-14);
    EXPECT_NEAR(a[k], 14.4 * std::cos(12.0 * t), 1e-3);
    EXPECT_NEAR(q_end[k], 0.1 * (1.0 - std::cos(24.0 * dt)), 1e-14);
    EXPECT_NEAR(v_end[k], 1.2 * std::sin(24.0 * dt), 1e-6);
  }
  EXPECT_GT(maximum(comm, largest), 10.0);
  EXPECT_LT(maximum(comm, out_of_balance), 1e-7);
}

// Viscosity and stiffness in one Jacobian: Newton's method is quadratic, or nearly so.
TEST_P(EveryPetscMethod, StepsTakeFewIterations) {
  const auto integrator = petsc(GetParam());
  step(*integrator, {0.01, 0.01});
  const StepAttempt attempt = integrator->attempt({0.02, 0.01});
  const int num_stages = GetParam().kind == PetscMethod::Kind::arkimex ? 3 : 1;
  EXPECT_LE(attempt.report.newton_iterations, 4 * num_stages);
  EXPECT_GE(attempt.report.linear_iterations, attempt.report.newton_iterations);
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryPetscMethod,
                         ::testing::ValuesIn(petsc_methods().begin(), petsc_methods().end()),
                         [](const auto& row) { return std::string(row.param.name); });

// At its default radius generalized-alpha is the implicit midpoint rule: the same numbers, step by step.
TEST_F(PetscIntegration, Alpha2IsTheImplicitMidpointRule) {
  const auto theirs = petsc(method_of(PetscMethod::Kind::alpha2));
  const auto ours = own("implicit-midpoint");
  const double dt = 0.02;
  for (int n = 1; n <= 10; ++n) {
    const StepAttempt a = theirs->attempt({n * dt, dt}), b = ours->attempt({n * dt, dt});
    ASSERT_EQ(a.report.outcome, StageOutcome::converged) << a.report.reason;

    ASSERT_EQ(b.report.outcome, StageOutcome::converged) << b.report.reason;
    // The tolerance of the two Newton methods, 1e-11 of the forces.
    EXPECT_LE(distance(a.q, b.q), 1e-10 * test::norm(b.q));
    EXPECT_LE(distance(a.v, b.v), 1e-10 * test::norm(b.v));
    EXPECT_LE(distance(a.last_q, b.last_q), 1e-10 * test::norm(b.q));
    EXPECT_LE(distance(a.last_a, b.last_a), 1e-9 * test::norm(b.last_a));
    EXPECT_NEAR(a.last_stage.time, b.last_stage.time, 1e-14);
    theirs->accept(a);
    ours->accept(b);
  }
}

// A step of TSBDF at its default order ends where a stage of the formula bdf2 does, from the two states before it.
TEST_F(PetscIntegration, BdfIsOursOnceItHasAPast) {
  const auto integrator = petsc(method_of(PetscMethod::Kind::bdf));
  const double dt = 0.02;
  step(*integrator, {dt, dt});
  const State old(integrator->state().view());
  step(*integrator, {2 * dt, dt});
  const State newer(integrator->state().view());
  step(*integrator, {3 * dt, dt});
  const auto extrapolated = [](const Handle<Vec>& a, const Handle<Vec>& b) {
    auto base = test::moved(a.get(), 0.0, a.get());
    check(VecAXPBY(base.get(), -1.0 / 3.0, 4.0 / 3.0, b.get()));
    return base;
  };
  const auto q0 = extrapolated(newer.q, old.q), v0 = extrapolated(newer.v, old.v);
  const auto q = test::moved(newer.q.get(), 0.0, newer.q.get());
  const StagePoint stage{.time = 3 * dt, .dt = 2 * dt / 3, .q0 = q0.get(), .v0 = v0.get(), .step_start = 2 * dt};
  problem().motion().start_stage(stage, q.get());
  const StageReport report = problem().system().solve(stage, q.get());
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_LE(distance(q.get(), integrator->state().q.get()), 1e-10 * test::norm(q.get()));
}

// With damping at high frequencies it is another method, of the same order.
TEST_F(PetscIntegration, OptionsReachTheMethod) {
  reference();
  const auto& method = method_of(PetscMethod::Kind::alpha2);
  const State midpoint = run(*petsc(method), 30, end);
  const Option radius("-ts_alpha_radius", "0.5");
  const State coarse = run(*petsc(method), 30, end), fine = run(*petsc(method), 60, end);
  EXPECT_GT(distance(coarse.q.get(), midpoint.q.get()), 1e-6);
  const double ratio = distance(coarse.q.get(), reference().q.get()) / distance(fine.q.get(), reference().q.get());
  EXPECT_NEAR(std::log2(ratio), 2.0, 0.1);
}

// A past of other lengths, and accelerations that do not balance the forces.
TEST_F(PetscIntegration, OtherOrdersAndRadiiGoOnFromWhatWasKept) {
  work_alone();
  for (const char* order : {"1", "3", "6"}) {
    const Option option("-ts_bdf_order", order);
    for (const int num_before : {1, 3, 9}) expect_continuation(method_of(PetscMethod::Kind::bdf), num_before);
  }
  const Option radius("-ts_alpha_radius", "0.5");
  expect_continuation(method_of(PetscMethod::Kind::alpha2), 3);
}

TEST_F(PetscIntegration, AnOptionThatNamesAnotherMethodIsRefused) {
  const Option type("-ts_type", "euler");
  EXPECT_THROW(petsc(method_of(PetscMethod::Kind::bdf)), PetscFailure);
}

// After a jump of the acceleration the past says nothing: a restart forgets it.
TEST_F(PetscIntegration, ARestartForgetsThePast) {
  work_alone();
  const auto& method = method_of(PetscMethod::Kind::bdf);
  const auto integrator = petsc(method);
  for (int n = 1; n <= 3; ++n) step(*integrator, {n * 0.01, 0.01});
  PetscIntegrator fresh(options_of(method), problem().potential(), problem().motion(), integrator->state().view());
  integrator->restart();
  for (int n = 4; n <= 5; ++n) {
    step(*integrator, {n * 0.01, 0.01});
    step(fresh, {n * 0.01, 0.01});
  }
  EXPECT_TRUE(equal(integrator->state().q.get(), fresh.state().q.get()));
  EXPECT_TRUE(equal(integrator->state().v.get(), fresh.state().v.get()));
}

/// A term that says of itself what the test wants.
class Claim final : public EnergyTerm {
 public:
  Claim(TermDeclaration declaration, std::size_t num_internal)
      : declaration_(declaration), num_internal_(num_internal) {}
  std::string_view name() const override { return "claim"; }
  TermDeclaration declaration() const override { return declaration_; }
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage&, std::span<const double>, std::span<double>) const override {}
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter&, Projection) const override {}
  std::size_t num_internal() const override { return num_internal_; }

 private:
  TermDeclaration declaration_;
  std::size_t num_internal_;
};

TEST_F(PetscIntegration, WhatItCannotSolveIsToldWithAReason) {
  EXPECT_EQ(why_not(problem().potential()), std::nullopt);
  const auto reason_with = [&](TermDeclaration declaration, std::size_t num_internal, std::optional<double> density) {
    ProblemSpec with = spec();
    with.density = density;
    with.loads = [=](const Solid&) {
      std::vector<std::unique_ptr<EnergyTerm>> terms;
      terms.push_back(std::make_unique<Claim>(declaration, num_internal));
      return terms;
    };
    Problem body(comm, mesh(), with);
    return why_not(body.potential()).value_or("");
  };
  EXPECT_NE(reason_with({.has_frozen_coefficients = true}, 0, 1000.0).find("`claim`"), std::string::npos);
  // Internal variables on one rank alone are every rank's business.
  EXPECT_NE(reason_with({}, rank(comm) == 0 ? 6 : 0, 1000.0).find("`claim`"), std::string::npos);
  EXPECT_NE(reason_with({}, 0, std::nullopt).find("inertia"), std::string::npos);
  EXPECT_EQ(reason_with({}, 0, 1000.0), "");
}

}  // namespace
}  // namespace pliant::test_petsc_integrator
