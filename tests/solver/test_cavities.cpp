// Bodies that move against cavities: a gas spring in closed form, and the orders of all methods.
#include "petsc/collective.hpp"
#include "solver/problem.hpp"
#include "time/integrator.hpp"

#include <cmath>

namespace pliant::test_cavities {
namespace {

using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Displacements and velocities of this rank.
struct Trajectory {
  std::vector<double> q, v;
};

Trajectory advance(Problem& problem, const Method& method, const test::Field& velocity, const Step& grid) {
  const auto q = problem.solid().vector(test::at_rest), v = problem.solid().vector(velocity);
  System system = problem.system();
  system.guess = Guess::extrapolated;
  Integrator integrator({method, Startup::dirk33}, system, {0.0, q.get(), v.get(), nullptr, {}});
  const int num_steps = static_cast<int>(std::lround(grid.time / grid.dt));
  for (int n = 1; n <= num_steps; ++n) {
    const double time = grid.time * n / num_steps;
    const StepAttempt attempt = integrator.attempt({time, time - integrator.state().time});
    EXPECT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
    if (attempt.report.outcome != StageOutcome::converged) break;
    integrator.accept(attempt);
  }
  return {test::local_values(integrator.state().q.get()), test::local_values(integrator.state().v.get())};
}

// A block of 1 m as a piston in a square tube, as good as rigid, runs into gas and is thrown back:
//
//     m x'' = -p(x) A,    (p + p_a) (V0 - A x)^n = p_a V0^n
TEST(GasSpring, ThrowsAPistonBack) {
  const Gas gas{0.8, 0.0, 1e5, 1.4, Expression(1.0)};
  const double mass = 1000.0, speed = 8.0, end = 0.2;
  ProblemSpec spec;
  spec.law = make_law("neo-hookean", 1e10, 0.0);
  spec.density = mass;
  spec.supports = {{[](const Point&) { return true; }, {std::nullopt, Expression(0.0), Expression(0.0)}}};
  spec.loads = [&](const Solid& solid) {
    auto facets = surface_facets(solid.mesh(), solid.layout(), test::face(0, 1.0));
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(
        std::make_unique<Cavity>(WettedSurface(solid.layout(), solid.pattern(), std::move(facets), 0), gas));
    return terms;
  };
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 2});
  });
  Problem problem(comm, file, spec);
  const Trajectory block = advance(problem, *find_method("dirk33"),
                                   [=](const Point&) {
                                     return Point{speed, 0.0, 0.0};
                                   },
                                   {end, end / 80});
  // Runge and Kutta's method with steps whose error does not matter.
  std::array<double, 2> y{0.0, speed};
  constexpr int num_steps = 2000;
  const auto slope = [&](const std::array<double, 2>& at) {
    return std::array{at[1], -gas.pressure(at[0], {}) / mass};
  };
  const auto ahead = [&](const std::array<double, 2>& k, double h) {
    return std::array{y[0] + h * k[0], y[1] + h * k[1]};
  };
  double deepest = 0.0;
  for (int n = 0; n < num_steps; ++n) {
    const double h = end / num_steps;
    const auto a = slope(y), b = slope(ahead(a, 0.5 * h)), c = slope(ahead(b, 0.5 * h)), d = slope(ahead(c, h));
    for (int i = 0; i < 2; ++i) y[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
    deepest = std::max(deepest, y[0]);
  }
  ASSERT_GT(deepest, 0.4);  // half of the gas's volume
  ASSERT_LT(y[1], -4.0);    // on its way back
  // The block gives way by p/E, some 1e-4; the method's error is smaller.
  for (std::size_t i = 0; i < block.q.size(); i += 3) EXPECT_NEAR(block.q[i], y[0], 2e-4);
  EXPECT_EQ(problem.statistics().projections, 0);
}

class CavityOrders : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Registry, CavityOrders, ::testing::Range<std::size_t>(0, methods().size()),
                         [](const auto& of) {
                           std::string name(methods()[of.param].name);
                           std::erase(name, '-');
                           return name;
                         });

// A cube that spins in a gas of which more and more is there: no method loses its order, in q or v.
TEST_P(CavityOrders, AreThoseOfTheMethod) {
  if (num_ranks(comm) > 1) GTEST_SKIP() << "the motion is that of one rank";
  const Method& method = methods()[GetParam()];
  constexpr double end = 0.5;
  const int num_fine = method.order == 1 ? 192 : 96;  // the first order shows later
  ProblemSpec spec;
  spec.law = make_law("neo-hookean", 5.0, 0.3);  // it vibrates at some rad/s
  spec.density = 1.0;
  spec.newton.relative = 1e-12;
  spec.loads = [](const Solid& solid) {
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(solid.cavity_around(Gas{3.0, 0.2, 1.0, 1.4, Expression("1+0.5*t")}));
    return terms;
  };
  const Scratch scratch(MPI_COMM_SELF);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 1});
  });
  Problem problem(MPI_COMM_SELF, file, spec);
  const auto end_after = [&](const Method& m, int num_steps) {
    const auto spinning = [](const Point& x) {
      return Point{-(x[1] - 0.5) + 0.2 * x[0], x[0] - 0.5 - 0.1 * x[1] * x[2], 0.3 * x[2]};
    };
    return advance(problem, m, spinning, {end, end / num_steps});
  };
  static const Trajectory exact = end_after(*find_method("dirk33"), 384);
  const Trajectory coarse = end_after(method, num_fine / 2), fine = end_after(method, num_fine);
  const auto expect_order = [&](const std::vector<double>& wrong, const std::vector<double>& less,
                                const std::vector<double>& right) {
    double error = 0.0, finer = 0.0;
    for (std::size_t i = 0; i < right.size(); ++i) {
      error = std::hypot(error, wrong[i] - right[i]);
      finer = std::hypot(finer, less[i] - right[i]);
    }
    EXPECT_NEAR(std::log2(error / finer), method.order, 0.15) << "errors " << error << ", " << finer;
  };
  expect_order(coarse.q, fine.q, exact.q);
  expect_order(coarse.v, fine.v, exact.v);
}

}  // namespace
}  // namespace pliant::test_cavities
