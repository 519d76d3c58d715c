// Steps of a stiff, viscous body that turns and vibrates: with a potential and without, with internal variables, on any
// number of ranks.
#include "energy/solid.hpp"
#include "solver/newton.hpp"
#include "time/integrator.hpp"

#include <algorithm>
#include <ostream>

namespace pliant::test_viscous {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;

struct StepCase {
  ViscosityVariant law;
  const char* method;
};

std::ostream& operator<<(std::ostream& out, const StepCase& c) {
  return out << test::name_of(c.law) << " " << c.method;
}

std::vector<StepCase> every_case() {
  std::vector<StepCase> cases;
  for (const char* method : {"bdf2", "dirk33"}) {
    // E = 1 MPa and steps of 10 ms: viscous stresses are as large as the elastic ones.
    for (const auto& form : strain_rates()) cases.push_back({WithStrainRate{KelvinVoigt{4e3, 6e3}, form.rate}, method});
    cases.push_back({Maxwell{5e5, 1e6, 0.03}, method});
    cases.push_back({WithStrainRate{StiffnessProportional{10.0}, StrainRate::exact}, method});
  }
  return cases;
}

struct End {
  int worst_iterations = 0;  ///< of Newton's in a step
  double kinetic_energy = 0.0;
  double largest_displacement = 0.0;
};

/// After ten steps. Collective on `comm`.
End after_steps(MPI_Comm comm, const std::string& file, const StepCase& c) {
  const Solid solid(comm, file, 1, 0);
  const auto elastic = solid.elastic(make_law("neo-hookean", 1e6, 0.4));
  const auto inertia = solid.inertia(1000.0, Mass::consistent);
  const auto viscous = solid.viscous(c.law);
  IncrementalPotential potential(solid.layout(), solid.pattern(), {elastic.get(), inertia.get(), viscous.get()},
                                 solid.nothing_prescribed());
  NewtonOptions options;
  options.relative = 1e-11;
  NewtonSolver solver(potential, options, LinearKind::cholesky);
  System system{[&](const StagePoint& stage, Vec q) { return solver.solve(stage, q); }};
  system.guess = Guess::extrapolated;
  const auto q = solid.vector([](const Point& x) { return Point{0.05 * x[0] * x[1], 0.0, 0.1 * x[2] * x[2]}; });
  const auto v = solid.vector([](const Point& x) { return Point{-5.0 * x[1], 5.0 * x[0], 2.0 * x[0] * x[2]}; });
  const Handle<Vec> z = potential.make_internal();
  if (z) {
    system.internal = potential.internal_variables();
    system.internal.complete_step(nullptr, q.get(), z.get());
  }
  Integrator integrator({*find_method(c.method)}, system, {0.0, q.get(), v.get(), z.get(), {}});
  End end;
  for (int n = 1; n <= 10; ++n) {
    const StepAttempt attempt = integrator.attempt({0.01 * n, 0.01});
    EXPECT_EQ(attempt.report.outcome, StageOutcome::converged) << "step " << n << ": " << attempt.report.reason;
    if (attempt.report.outcome != StageOutcome::converged) return end;
    end.worst_iterations = std::max(end.worst_iterations, attempt.report.newton_iterations);
    integrator.accept(attempt);
  }
  end.kinetic_energy = sum(comm, inertia->kinetic_energy(test::local_values(integrator.state().v.get())));
  PetscReal largest = 0.0;
  check(VecNorm(integrator.state().q.get(), NORM_INFINITY, &largest));
  end.largest_displacement = largest;
  return end;
}

class ViscousSteps : public ::testing::TestWithParam<StepCase> {
 protected:
  Scratch scratch_{MPI_COMM_WORLD};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, BodySpec{1, Shape::jittered, 2});
  });
};

INSTANTIATE_TEST_SUITE_P(Registry, ViscousSteps, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return test::name_of(of.param.law) + "_" + of.param.method; });

TEST_P(ViscousSteps, ConvergeInFewIterationsAndDoNotDependOnTheNumberOfRanks) {
  const End end = after_steps(MPI_COMM_WORLD, file_, GetParam());
  const End alone = after_steps(MPI_COMM_SELF, file_, GetParam());
  ASSERT_GT(alone.kinetic_energy, 100.0);
  ASSERT_GT(alone.largest_displacement, 0.1);
  EXPECT_NEAR(end.kinetic_energy, alone.kinetic_energy, 1e-8 * alone.kinetic_energy);
  EXPECT_NEAR(end.largest_displacement, alone.largest_displacement, 1e-8 * alone.largest_displacement);
  // Quadratic convergence with a potential; the exact rate's symmetric matrix gains some two digits per iteration.
  const int per_stage = test::is_potential(GetParam().law) ? 5 : 9;
  EXPECT_LE(end.worst_iterations, per_stage * find_method(GetParam().method)->num_stages);
  RecordProperty("newton_iterations_of_the_worst_step", end.worst_iterations);
}

}  // namespace
}  // namespace pliant::test_viscous
