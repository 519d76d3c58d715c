// Stages that are to be retried: no rank hangs, the reason is said, and the next stage is none the worse.
#include "solver/on_cubes.hpp"

#include <limits>

namespace pliant::test_retried_stages {
namespace {

using test::Problem;
using test::ProblemSpec;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

class RetriedStages : public test::OnCubes {};

// A support that presses the body flat: no rank hangs, all ask for a smaller step, and the next stage is none the
// worse.
TEST_F(RetriedStages, APrescribedMotionThatFlattensTheBody) {
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e6, 0.3));
  spec.supports.push_back({test::face(0, 1.0), {Expression("t < 2 ? -1.2 : -0.05"), std::nullopt, std::nullopt}});
  Problem problem(comm, mesh(3), spec);
  const auto v0 = problem.solid().vector(test::at_rest), q = problem.solid().vector(test::at_rest);
  const auto flat = problem.solve(1.0, 1.0, problem.solid().vector(test::at_rest), v0, q);
  EXPECT_EQ(flat.outcome, StageOutcome::retry);
  EXPECT_FALSE(flat.reason.empty());
  expect_same_everywhere(flat);
  const auto sound = problem.solve(9.0, 1.0, problem.solid().vector(test::at_rest), v0, q);
  EXPECT_EQ(sound.outcome, StageOutcome::converged) << sound.reason;
  expect_same_everywhere(sound);
}

// No inertia and no support: the matrix is singular. Not converged, or at the state of rest, but never stuck.
TEST_F(RetriedStages, AFloatingBodyUnderLoad) {
  for (const auto kind : {LinearKind::cholesky, LinearKind::amg}) {
    ProblemSpec spec;
    spec.law = make_law("neo-hookean", 1e6, 0.3);
    spec.loads = traction(1e4, 0.0, 0.0);
    spec.linear = kind;
    spec.newton.max_iterations = 10;
    Problem problem(comm, mesh(2), spec);
    const auto q = problem.solid().vector(test::at_rest);
    const auto report = problem.solve_static(q);
    EXPECT_EQ(report.outcome, StageOutcome::retry);
    expect_same_everywhere(report);
  }
}

/// A Hessian that is not a number as long as the test says so.
class SpoiltHessian final : public EnergyTerm {
 public:
  SpoiltHessian(const Solid& solid, const bool* is_spoilt)
      : block_(solid.pattern().block(0, 0)), is_spoilt_(is_spoilt) {}
  std::string_view name() const override { return "spoilt"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage&, std::span<const double>, std::span<double>) const override {}
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter& K, Projection) const override {
    if (*is_spoilt_) K.block(0, block_).values[0] += std::numeric_limits<double>::quiet_NaN();
  }

 private:
  std::int32_t block_;
  const bool* is_spoilt_;
};

TEST_F(RetriedStages, AStageWithoutAFactorDoesNotSpoilTheNext) {
  bool is_spoilt = true;
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e6, 0.3));
  spec.loads = [&](const Solid& solid) {
    auto terms = with_term<SpoiltHessian>(&is_spoilt)(solid);
    terms.push_back(solid.traction({Expression(1e4), Expression(), Expression()}));
    return terms;
  };
  Problem problem(comm, mesh(2), spec);
  EXPECT_EQ(problem.solve_static(problem.solid().vector(test::at_rest)).outcome, StageOutcome::retry);
  is_spoilt = false;
  const auto report = problem.solve_static(problem.solid().vector(test::at_rest));
  EXPECT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  expect_same_everywhere(report);
}

TEST_F(RetriedStages, OutOfIterations) {
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e6, 0.3));
  spec.loads = traction(3e5, 0.0, 0.0);
  spec.newton.max_iterations = 1;
  Problem problem(comm, mesh(2), spec);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  EXPECT_EQ(report.outcome, StageOutcome::retry);
  EXPECT_EQ(report.newton_iterations, 1);
  EXPECT_NE(report.reason.find("iterations"), std::string::npos);
}

/// Says, from a time on, that every step away from the start is uphill, which its gradient does not know.
class Liar final : public EnergyTerm {
 public:
  explicit Liar(const Solid& solid) : size_(3 * solid.layout().num_owned_nodes) {}
  std::string_view name() const override { return "liar"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage& stage, std::span<const double> q) const override {
    double away = 0.0;
    for (PetscInt i = 0; i < size_; ++i) away += std::abs(q[i] - stage.q0[i]);
    return stage.time > 1.5 ? 1e9 * away : 0.0;
  }
  void add_gradient(const LocalStage&, std::span<const double>, std::span<double>) const override {}
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter&, Projection) const override {}

 private:
  PetscInt size_;
};

// Also after a stage whose last step was tiny: SNES must not take that for the failed stage's convergence.
TEST_F(RetriedStages, ALineSearchWithoutDescent) {
  ProblemSpec spec = clamped(make_law("neo-hookean", 1e6, 0.3));
  spec.density = 1000.0;
  spec.newton.relative = 1e-12;
  spec.loads = [](const Solid& solid) {
    auto terms = with_term<Liar>()(solid);
    terms.push_back(solid.gravity(1000.0, {Expression(), Expression(), Expression("-10*t")}));
    return terms;
  };
  Problem problem(comm, mesh(2), spec);
  const auto v0 = problem.solid().vector(test::at_rest), q = problem.solid().vector(test::at_rest);
  const auto sound = problem.solve(1.0, 1.0, problem.solid().vector(test::at_rest), v0, q);
  ASSERT_EQ(sound.outcome, StageOutcome::converged) << sound.reason;
  const auto q0 = test::moved(q.get(), 0.0, q.get());
  const auto report = problem.solve(2.0, 1.0, q0, v0, q);
  EXPECT_EQ(report.outcome, StageOutcome::retry) << report.reason;
  expect_same_everywhere(report);
}

}  // namespace
}  // namespace pliant::test_retried_stages
