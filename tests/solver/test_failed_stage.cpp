// What the solver tells of stages that it could not solve.
#include "fem/deformed_cell.hpp"
#include "solver/failed_stage.hpp"
#include "solver/problem.hpp"

#include <cmath>

namespace pliant::test_failed_stage {
namespace {

using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

class FailedStages : public ::testing::Test {
 protected:
  /// Clamped at x = 0, pulled sideways.
  ProblemSpec pulled(double traction, int max_iterations) const {
    ProblemSpec spec;
    spec.law = make_law("neo-hookean", 1e6, 0.3);
    spec.supports = {{test::face(0, 0.0), test::fixed()}};
    spec.loads = [=](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> loads;
      loads.push_back(solid.traction({Expression(traction), Expression(0.3 * traction), Expression()}));
      return loads;
    };
    spec.newton.max_iterations = max_iterations;
    return spec;
  }
  static double norm(Vec x) {
    PetscReal result = 0.0;
    check(VecNorm(x, NORM_2, &result));
    return result;
  }

  Scratch scratch_{comm};
  std::string mesh_ = scratch_.file("cube.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::straight, 2});
  });
};

TEST_F(FailedStages, AreNoneWhereAllIsWell) {
  Problem problem(comm, mesh_, pulled(3e5, 50));
  EXPECT_FALSE(problem.examine());
  const auto q = problem.solid().vector(test::at_rest);
  ASSERT_EQ(problem.solve_static(q).outcome, StageOutcome::converged);
  EXPECT_FALSE(problem.examine());
}

TEST_F(FailedStages, TellTheIterationsAndTheLine) {
  Problem problem(comm, mesh_, pulled(3e5, 2));
  const auto q = problem.solid().vector(test::at_rest);
  const auto report = problem.solve_static(q);
  ASSERT_EQ(report.outcome, StageOutcome::retry);
  const auto stage = problem.examine();
  ASSERT_TRUE(stage);
  ASSERT_EQ(stage->iterations.size(), 3u);
  EXPECT_EQ(stage->iterations[0].step_length, 0.0);
  int linear_iterations = 0;
  for (std::size_t i = 1; i < stage->iterations.size(); ++i) {
    EXPECT_GT(stage->iterations[i].step_length, 0.0);
    EXPECT_LE(stage->iterations[i].step_length, 1.0);
    linear_iterations += stage->iterations[i].linear_iterations;
  }
  EXPECT_EQ(linear_iterations, report.linear_iterations);
  EXPECT_GT(stage->force_scale, 0.0);
  EXPECT_DOUBLE_EQ(stage->tolerance, 1e-8 * stage->force_scale);
  EXPECT_GT(stage->iterations.back().residual, stage->tolerance);
  // Where the iteration ended: the residual there is the last one.
  EXPECT_NEAR(norm(stage->residual.get()), stage->iterations.back().residual, 1e-9 * stage->force_scale);
  EXPECT_GT(norm(stage->displacement.get()), 0.0);
  EXPECT_GT(norm(stage->direction.get()), 0.0);

  const auto& profile = stage->profile;
  ASSERT_EQ(profile.size(), 21u);
  EXPECT_EQ(stage->measure, FailedStage::Measure::potential);
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_LT(profile[k].length, profile[k + 1].length);
    EXPECT_DOUBLE_EQ(profile[k].length, -profile[20 - k].length);
  }
  EXPECT_EQ(profile[10].change, 0.0);
  // The slope that the residual gives is that of the profile: central differences of 1e-4 of a step.
  ASSERT_TRUE(stage->slope);
  const double h = profile[12].length;
  EXPECT_NEAR((profile[12].change - profile[8].change) / (2.0 * h) / *stage->slope, 1.0, 1e-3);
  EXPECT_GT(std::abs(*stage->slope), 0.0);

  // To look did not change anything.
  const auto again = problem.examine();
  ASSERT_TRUE(again);
  EXPECT_EQ(again->profile.front().change, profile.front().change);
  EXPECT_EQ(again->iterations.size(), 3u);
}

TEST_F(FailedStages, BeyondABarrierHaveNoIterations) {
  ProblemSpec spec = pulled(1e3, 50);
  spec.supports.push_back({test::face(0, 1.0), {Expression(-1.2), std::nullopt, std::nullopt}});
  Problem problem(comm, mesh_, spec);
  const auto q = problem.solid().vector(test::at_rest);
  ASSERT_EQ(problem.solve_static(q).outcome, StageOutcome::retry);
  const auto stage = problem.examine();
  ASSERT_TRUE(stage);
  EXPECT_TRUE(stage->iterations.empty());
  EXPECT_TRUE(stage->profile.empty());
  EXPECT_EQ(stage->force_scale, 0.0);
  EXPECT_EQ(norm(stage->direction.get()), 0.0);
  EXPECT_TRUE(std::isnan(norm(stage->residual.get())));
  const NodeLayout& layout = problem.solid().layout();
  const auto u = test::local_values(stage->displacement.get());
  double least = 1.0;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    least = std::min(least, deformed_cell(layout, c, u).volume_ratio);
  }
  EXPECT_NEAR(minimum(comm, least), 1.0 - 1.2 / 0.5, 1e-9);  // the layer next to the face, half of the cube

  // The next stage is another one.
  ASSERT_EQ(problem.solve_static(problem.solid().vector(test::at_rest)).outcome, StageOutcome::retry);
  EXPECT_TRUE(problem.examine());
}

}  // namespace
}  // namespace pliant::test_failed_stage
