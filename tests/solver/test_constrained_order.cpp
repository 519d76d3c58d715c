// Constraints that move cost no method its order.
#include "solver/tied_problem.hpp"
#include "time/integrator.hpp"
#include "time/method.hpp"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pliant::test_constrained_order {
namespace {

using test::face;
using test::Point;
using test::Scratch;
using test::Shape;
using test::TiedProblem;
using test::TiedSpec;

const MPI_Comm comm = MPI_COMM_WORLD;

struct OrderCase {
  Method method;
  std::string name;
  std::vector<test::TestConstraint> constraints;
  bool has_pressures;
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
      cases.push_back({method, name, constraints, false});
      if (method.stiffly_accurate) cases.push_back({method, name + "WithPressures", constraints, true});
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
  if (num_ranks(comm) > 1) GTEST_SKIP() << "the motion is that of one rank";
  const Scratch scratch(MPI_COMM_SELF);
  const auto file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 1});
  });
  TiedSpec spec;
  // It vibrates at some rad/s; elements of second order vibrate faster.
  spec.law = make_law("neo-hookean", c.has_pressures ? 1.25 : 5.0, 0.3);
  spec.density = 1.0;
  spec.constraints = c.constraints;
  spec.has_pressures = c.has_pressures;
  spec.order = c.has_pressures ? 2 : 1;
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
}  // namespace pliant::test_constrained_order
