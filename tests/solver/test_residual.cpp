// Stages without a potential: solved on the residual.
#include "solver/problem.hpp"
#include "solver/small_equation.hpp"

namespace pliant::test_residual {
namespace {

using test::Field;
using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Recorder;
using test::Scratch;
using test::SmallEquation;
using test::SmallFunction;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

/// A circulatory load at every node: the force s w cross u, which turns with the displacement and has no potential.
class Swirl final : public EnergyTerm {
 public:
  enum class Tangent { exact, none };
  Swirl(const Solid& solid, double s, Tangent tangent)
      : size_(solid.layout().num_owned_nodes), s_(s), tangent_(tangent) {
    for (PetscInt a = 0; a < size_; ++a) blocks_.push_back(solid.pattern().block(a, a));
  }
  std::string_view name() const override { return "swirl"; }
  TermDeclaration declaration() const override {
    return {.is_potential = false,
            .symmetry = tangent_ == Tangent::exact ? Symmetry::unsymmetric : Symmetry::symmetric,
            .account = Account::load};
  }
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage&, std::span<const double> q, std::span<double> r) const override {
    for (PetscInt a = 0; a < size_; ++a) {
      r[3 * a + 1] += s_ * q[3 * a + 2];
      r[3 * a + 2] -= s_ * q[3 * a + 1];
    }
  }
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter& K, Projection) const override {
    if (tangent_ == Tangent::none) return;
    for (PetscInt a = 0; a < size_; ++a) {
      const auto [values, stride] = K.block(a, blocks_[a]);
      values[stride + 2] += s_;
      values[2 * stride + 1] -= s_;
    }
  }

 private:
  PetscInt size_;
  double s_;
  Tangent tangent_;
  std::vector<std::int32_t> blocks_;
};

class Residual : public ::testing::Test {
 protected:
  /// A cube clamped at x = 0, pulled at its tip, under the swirl.
  static ProblemSpec swirled(Swirl::Tangent tangent, LinearKind linear) {
    ProblemSpec spec;
    spec.law = make_law("neo-hookean", 1e6, 0.3);
    spec.supports = {{test::face(0, 0.0), test::fixed()}};
    spec.newton.relative = 1e-11;
    spec.linear = linear;
    spec.loads = [=](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> terms;
      terms.push_back(solid.traction({Expression(2e4), Expression(1e5), Expression()}));
      terms.push_back(std::make_unique<Swirl>(solid, 4e3, tangent));
      return terms;
    };
    return spec;
  }
  /// A strip of length 10, width 1 and height 0.5, clamped at x = 0, with a follower pressure from below.
  static ProblemSpec strip(int order, double pressure) {
    ProblemSpec spec;
    spec.order = order;
    spec.law = make_law("saint-venant-kirchhoff", 1e6, 0.0);
    spec.supports = {{test::face(0, 0.0), test::fixed()}};
    spec.newton.relative = 1e-11;
    spec.loads = [=](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> terms;
      auto facets = surface_facets(solid.mesh(), solid.layout(), test::face(2, 0.0));
      terms.push_back(std::make_unique<FollowerPressure>(solid.layout(), solid.pattern(), std::move(facets),
                                                         Expression(pressure), Rim::free));
      return terms;
    };
    return spec;
  }
  std::string cube(int n) const {
    return scratch_.file("cube.msh", [&](const std::string& f) { test::write_body(f, {1, test::Shape::jittered, n}); });
  }
  std::string strip_mesh(int n) const {
    return scratch_.file("strip.msh", [&](const std::string& f) {
      test::write_box_msh(f, {10.0, 1.0, 0.5}, {n, 1, 1});
    });
  }
  static void expect_same_everywhere(const StageReport& report) {
    EXPECT_EQ(broadcast(comm, report.reason), report.reason);
    EXPECT_EQ(maximum(comm, report.newton_iterations), minimum(comm, report.newton_iterations));
  }
  /// |r| over the sum of the forces that balance.
  static double relative_residual(Problem& problem, Vec q) {
    const Handle<Vec> r = problem.potential().make_vector();
    problem.potential().gradient(q, r.get());
    return test::norm(r.get()) / problem.potential().force_scale(q);
  }

  /// Where the solver stops at the latest: four times the rounding errors of the forces, over the same sum.
  static double relative_rounding(Problem& problem, Vec q) {
    return 4.0 * problem.potential().rounding_floor(q) / problem.potential().force_scale(q);
  }

  Scratch scratch_{comm};
};

/// Displacement of the tip of an inextensible beam under a load w per length that stays normal to it:
///     EI theta' = M,  M' = -Q,  Q' + theta' N = -w,  N' - theta' Q = 0,
/// in the frame of the section, where the free tip (M = Q = N = 0) is a state to start from; then turned so that the
/// clamped end is straight.
std::array<double, 2> tip_of_beam(double length, double stiffness, double w) {
  using State = std::array<double, 6>;  // M, Q, N, theta, x, z along s from the tip
  const auto rate = [&](const State& y) {
    const double kappa = -y[0] / stiffness;  // s runs against the beam's arc length
    return State{y[1], -kappa * y[2] + w, kappa * y[1], kappa, -std::cos(y[3]), -std::sin(y[3])};
  };
  const auto moved = [](const State& y, double h, const State& k) {
    State z = y;
    for (std::size_t i = 0; i < z.size(); ++i) z[i] += h * k[i];
    return z;
  };
  State y{};
  constexpr int n = 2000;
  const double h = length / n;
  for (int i = 0; i < n; ++i) {
    const State k1 = rate(y), k2 = rate(moved(y, h / 2, k1)), k3 = rate(moved(y, h / 2, k2)),
                k4 = rate(moved(y, h, k3));
    for (std::size_t j = 0; j < y.size(); ++j) y[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
  }
  const double c = std::cos(y[3]), s = std::sin(y[3]);  // the clamp's direction; the tip is at the origin
  return {-(c * y[4] + s * y[5]) - length, -(-s * y[4] + c * y[5])};
}

// At small loads the beam is that of the textbook, w L^4 / 8 EI: the reference is checked first.
TEST(BeamReference, SmallLoadsBendItAsTheLinearBeam) {
  const auto [along, across] = tip_of_beam(10.0, 1e4, 1e-3);
  EXPECT_NEAR(across, 1e-3 * 1e4 / 8e4, 1e-9);
  EXPECT_NEAR(along, 0.0, 1e-8);
}

// Deflections of a quarter of the length. The strip's shear and the strain along it are of the order of (h/L)^2 =
// 0.0025, of the strain at its surfaces of 0.05 squared, and of the pressure acting at h/2 from the axis.
TEST_F(Residual, AFollowerLoadedStripIsTheBeam) {
  const double pressure = 20.0;
  Problem problem(comm, strip_mesh(10), strip(2, pressure));
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  expect_same_everywhere(report);
  EXPECT_LE(relative_residual(problem, q.get()), std::max(1e-10, relative_rounding(problem, q.get())));
  Point tip{};
  int count = 0;
  {
    const ConstArrayView u(q.get());
    for (PetscInt a = 0; a < problem.solid().layout().num_owned_nodes; ++a) {
      const Point X = problem.solid().layout().position(a);
      if (X[0] < 10.0 - 1e-9 || std::abs(X[2] - 0.25) > 1e-9) continue;
      ++count;
      for (int i = 0; i < 3; ++i) tip[i] += u[3 * a + i];
    }
  }
  const double num = sum(comm, static_cast<double>(count));
  const auto [along, across] = tip_of_beam(10.0, 1e6 * 0.125 / 12.0, pressure);
  ASSERT_GT(across, 2.0);
  EXPECT_NEAR(sum(comm, tip[2]) / num, across, 0.01 * across);
  EXPECT_NEAR(sum(comm, tip[0]) / num, along, 0.02 * std::abs(along));
  EXPECT_EQ(problem.statistics().minimisations, 0);
  EXPECT_EQ(problem.statistics().residual_solves, 1);
}

// With the consistent tangent and accurate linear solutions every step squares the error.
TEST_F(Residual, NewtonIsQuadratic) {
  check(PetscOptionsSetValue(nullptr, "-ksp_rtol", "1e-12"));
  Problem problem(comm, strip_mesh(10), strip(1, 20.0));
  Recorder recorder(problem.potential());
  NewtonOptions options;
  options.relative = 1e-11;
  NewtonSolver solver(recorder, options, LinearKind::cholesky);
  check(PetscOptionsClearValue(nullptr, "-ksp_rtol"));
  const auto q0 = problem.solid().vector(test::at_rest), v0 = problem.solid().vector(test::at_rest);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = solver.solve({1.0, 1.0, q0.get(), v0.get()}, q.get());
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  // r_{k+1} <= C r_k^2, with the C of the last step but one for the last; in units of the first residual.
  auto r = recorder.residuals();
  const Handle<Vec> last = problem.potential().make_vector();
  problem.potential().gradient(q.get(), last.get());
  r.push_back(test::norm(last.get()));
  ASSERT_GE(r.size(), 4u);
  const double before = r[r.size() - 3] / r[0], at = r[r.size() - 2] / r[0], after = r.back() / r[0];
  EXPECT_LE(at, 1e-3);
  EXPECT_LE(after, 10.0 * at / (before * before) * at * at + 1e-11);
}

TEST_F(Residual, ACirculatoryLoadIsTheSameOnAnyNumberOfRanks) {
  const auto file = cube(4);
  for (const auto kind : {LinearKind::cholesky, LinearKind::amg}) {
    const auto spec = swirled(Swirl::Tangent::exact, kind);
    Problem problem(comm, file, spec), alone(MPI_COMM_SELF, file, spec);
    const auto q = problem.solid().vector(test::at_rest), expected = alone.solid().vector(test::at_rest);
    const auto report = problem.solve_static(q);
    ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
    ASSERT_EQ(alone.solve_static(expected).outcome, StageOutcome::converged);
    expect_same_everywhere(report);
    EXPECT_LE(report.newton_iterations, 8);
    EXPECT_LE(relative_residual(problem, q.get()), 1e-10);
    const double size = test::norm(q.get());
    ASSERT_GT(size, 0.1);
    EXPECT_LE(test::deviation(problem.solid(), q.get(), test::by_place(alone.solid(), expected.get())), 1e-8 * size);
    // It is the swirl that moves the body out of the plane of the traction.
    const ConstArrayView u(q.get());
    double sideways = 0.0;
    for (PetscInt a = 0; a < problem.solid().layout().num_owned_nodes; ++a)
      sideways = std::max(sideways, std::abs(u[3 * a + 2]));
    EXPECT_GT(maximum(comm, sideways), 0.01);
  }
}

// K without the swirl: symmetric, and no more than an approximation.
TEST_F(Residual, AnApproximateTangentConvergesLinearly) {
  const auto file = cube(3);
  Problem exact(comm, file, swirled(Swirl::Tangent::exact, LinearKind::cholesky));
  Problem approximate(comm, file, swirled(Swirl::Tangent::none, LinearKind::cholesky));
  const auto q = exact.solid().vector(test::at_rest), p = exact.solid().vector(test::at_rest);
  const auto quick = exact.solve_static(q), slow = approximate.solve_static(p);
  ASSERT_EQ(quick.outcome, StageOutcome::converged) << quick.reason;
  ASSERT_EQ(slow.outcome, StageOutcome::converged) << slow.reason;
  EXPECT_GT(slow.newton_iterations, quick.newton_iterations + 2);
  EXPECT_LE(test::distance(q.get(), p.get()), 1e-8 * test::norm(q.get()));
  expect_same_everywhere(slow);
}

// The documented rule, in its strong form: for the swirl, whose tangent is nearly constant, the residual falls at every
// step.
TEST_F(Residual, TheResidualFallsAtEveryStep) {
  for (const auto tangent : {Swirl::Tangent::exact, Swirl::Tangent::none}) {
    Problem problem(comm, cube(3), swirled(tangent, LinearKind::cholesky));
    Recorder recorder(problem.potential());
    NewtonOptions options;
    NewtonSolver solver(recorder, options, LinearKind::cholesky);
    const auto q0 = problem.solid().vector(test::at_rest), v0 = problem.solid().vector(test::at_rest);
    const auto q = problem.solid().vector(test::at_rest);
    ASSERT_EQ(solver.solve({1.0, 1.0, q0.get(), v0.get()}, q.get()).outcome, StageOutcome::converged);
    const auto& r = recorder.residuals();
    ASSERT_GE(r.size(), 3u);
    for (std::size_t k = 2; k < r.size(); ++k) EXPECT_LE(r[k], 0.95 * r[k - 1]) << k;
  }
}

// A matrix without an inverse is a stage without a solution, the second time too.
TEST_F(Residual, SingularMatricesAreTold) {
  SmallFunction function;
  function.n = 2;
  function.residual = [](std::span<const double>) { return std::vector{1.0, 2.0}; };
  function.tangent = [](std::span<const double>) { return std::vector{0.0, 0.0, 0.0, 0.0}; };
  SmallEquation equation(comm, function);
  NewtonSolver solver(equation, {}, LinearKind::cholesky);
  const auto q0 = equation.make_vector(), v0 = equation.make_vector(), q = equation.make_vector();
  for (int time = 0; time < 3; ++time) {
    const auto report = solver.solve({1.0, 1.0, q0.get(), v0.get()}, q.get());
    EXPECT_EQ(report.outcome, StageOutcome::retry);
    EXPECT_NE(report.reason.find("singular"), std::string::npos) << report.reason;
  }
}

// A pressure on the tip that a full step answers by turning cells inside out.
TEST_F(Residual, StepsThatWouldInvertAreCapped) {
  ProblemSpec spec;
  spec.law = make_law("neo-hookean", 1e5, 0.3);
  spec.supports = {{test::face(0, 0.0), test::fixed()}};
  spec.loads = [](const Solid& solid) {
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(solid.pressure(Expression(1e5)));
    return terms;
  };
  Problem problem(comm, cube(3), spec);
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  EXPECT_GT(problem.statistics().capped_steps, 0);
  expect_same_everywhere(report);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  double lowest = 1.0;
  problem.elastic().stresses({.q = test::local_values(q.get())},
                             [&](PetscInt, const CellStress& s) { lowest = std::min(lowest, s.volume_ratio); });
  lowest = minimum(comm, lowest);
  EXPECT_GT(lowest, 0.0);
  EXPECT_LT(lowest, 0.6);
}

TEST_F(Residual, TheLogSaysWhichPathAndWhy) {
  Problem circulatory(comm, cube(1), swirled(Swirl::Tangent::exact, LinearKind::cholesky));
  const auto why = describe(circulatory.potential(), LinearKind::cholesky);
  EXPECT_NE(why.find("residual"), std::string::npos) << why;
  EXPECT_NE(why.find("'swirl' has no potential"), std::string::npos) << why;
  EXPECT_NE(why.find("LU"), std::string::npos) << why;
  ProblemSpec spec;
  spec.law = make_law("linear", 1.0, 0.3);
  Problem conservative(comm, cube(1), spec);
  const auto plain = describe(conservative.potential(), LinearKind::cholesky);
  EXPECT_NE(plain.find("incremental potential"), std::string::npos) << plain;
  EXPECT_NE(plain.find("LDL^T"), std::string::npos) << plain;
  ASSERT_EQ(conservative.solve_static(conservative.solid().vector(test::at_rest)).outcome, StageOutcome::converged);
  EXPECT_EQ(conservative.statistics().minimisations, 1);
  EXPECT_EQ(conservative.statistics().residual_solves, 0);
}

class SmallResidual : public ::testing::TestWithParam<LinearKind> {
 protected:
  StageReport solve(const SmallFunction& function, double start, Handle<Vec>& q) {
    SmallEquation equation(comm, function);
    NewtonOptions options;
    options.absolute = 1e-11;
    options.relative = 1e-12;
    NewtonSolver solver(equation, options, GetParam());
    const auto v0 = equation.filled(0.0), q0 = equation.filled(start);
    q = equation.filled(start);
    return solver.solve({1.0, 1.0, q0.get(), v0.get()}, q.get());
  }
};

INSTANTIATE_TEST_SUITE_P(Kinds, SmallResidual, ::testing::Values(LinearKind::cholesky, LinearKind::amg),
                         [](const auto& of) { return of.param == LinearKind::cholesky ? "direct" : "multigrid"; });

// Six unknowns, the first three stiffer by 1e6 than the others, coupled without symmetry:
//     k_i (x_i - i) + 0.3 sqrt(k_i k_{i+1}) (sin x_{i+1} - sin(i + 1)) = 0,   solved by x_i = i.
TEST_P(SmallResidual, SixUnknownsOnOneRank) {
  const auto k = [](PetscInt i) { return i < 3 ? 1e6 : 1.0; };
  const auto coupling = [k](PetscInt i, PetscInt j) { return 0.3 * std::sqrt(k(i) * k(j)); };
  SmallFunction function;
  function.n = 6;
  function.residual = [=](std::span<const double> x) {
    std::vector<double> r(6);
    for (PetscInt i = 0; i < 6; ++i) {
      const PetscInt j = (i + 1) % 6;
      r[i] =
          k(i) * (x[i] - static_cast<double>(i)) + coupling(i, j) * (std::sin(x[j]) - std::sin(static_cast<double>(j)));
    }
    return r;
  };
  function.tangent = [=](std::span<const double> x) {
    std::vector<double> K(36, 0.0);
    for (PetscInt i = 0; i < 6; ++i) {
      const PetscInt j = (i + 1) % 6;
      K[6 * i + i] = k(i);
      K[6 * i + j] = coupling(i, j) * std::cos(x[j]);
    }
    return K;
  };
  Handle<Vec> q;
  const auto report = solve(function, 0.0, q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_EQ(maximum(comm, report.newton_iterations), minimum(comm, report.newton_iterations));
  const ConstArrayView x(q.get());
  for (std::size_t i = 0; i < x.span().size(); ++i) EXPECT_NEAR(x.span()[i], static_cast<double>(i), 1e-9);
}

// arctan: full steps from 3 diverge, ever further; the line search brings them back.
TEST_P(SmallResidual, StepsThatOvershootAreShortened) {
  SmallFunction function;
  function.n = 2;
  function.residual = [](std::span<const double> x) {
    return std::vector{std::atan(x[0]), std::atan(x[1]) + 0.1 * x[0]};
  };
  function.tangent = [](std::span<const double> x) {
    return std::vector{1.0 / (1.0 + x[0] * x[0]), 0.0, 0.1, 1.0 / (1.0 + x[1] * x[1])};
  };
  Handle<Vec> q;
  const auto report = solve(function, 3.0, q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  EXPECT_LE(test::norm(q.get()), 1e-9);
}

// A matrix that is singular at the start, and a later one that is not: the solver gets over it.
TEST_P(SmallResidual, ASingularMatrixIsGotOver) {
  SmallFunction function;
  function.n = 2;
  function.residual = [](std::span<const double> x) { return std::vector{x[0] * x[0] * x[0] - 8.0, x[1] - x[0]}; };
  function.tangent = [](std::span<const double> x) { return std::vector{3.0 * x[0] * x[0], 0.0, -1.0, 1.0}; };
  Handle<Vec> q;
  const auto report = solve(function, 0.0, q);
  ASSERT_EQ(report.outcome, StageOutcome::converged) << report.reason;
  const ConstArrayView x(q.get());
  for (const double xi : x.span()) EXPECT_NEAR(xi, 2.0, 1e-9);
}

// No solution: a smaller step is asked for, by every rank in the same words.
TEST_P(SmallResidual, WithoutASolutionItIsToBeRetried) {
  SmallFunction function;
  function.n = 2;
  function.residual = [](std::span<const double> x) { return std::vector{1.0 + x[0] * x[0], x[1] - x[0]}; };
  function.tangent = [](std::span<const double> x) { return std::vector{2.0 * x[0], 0.0, -1.0, 1.0}; };
  Handle<Vec> q;
  const auto report = solve(function, 1.0, q);
  EXPECT_EQ(report.outcome, StageOutcome::retry);
  EXPECT_EQ(broadcast(comm, report.reason), report.reason);
}

TEST_F(Residual, AFailedStageTellsOfItsMerit) {
  ProblemSpec spec = swirled(Swirl::Tangent::exact, LinearKind::cholesky);
  spec.newton.max_iterations = 1;
  Problem problem(comm, cube(2), spec);
  const auto q = problem.solid().vector(test::at_rest);
  ASSERT_EQ(problem.solve_static(q).outcome, StageOutcome::retry);
  const auto stage = problem.examine();
  ASSERT_TRUE(stage);
  EXPECT_EQ(stage->measure, FailedStage::Measure::merit);
  EXPECT_FALSE(stage->slope);
  ASSERT_EQ(stage->profile.size(), 21u);
  for (const auto& sample : stage->profile) EXPECT_TRUE(std::isfinite(sample.change));
  EXPECT_NE(stage->profile.front().change, 0.0);
  EXPECT_EQ(stage->iterations.size(), 2u);
}

}  // namespace
}  // namespace pliant::test_residual
