// What is tried in which order without inertia, on a scripted iteration.
#include "solver/equilibrium.hpp"
#include "solver/scripted_iteration.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_equilibrium_search {
namespace {

using test::Script;

class EquilibriumSearches : public ::testing::Test {
 protected:
  EquilibriumSearches() { objective_.begin_stage({.q0 = q_.get()}); }
  /// A stage whose first runs fail.
  StageReport stage(std::size_t failures, Vec second = nullptr, int max_iterations = 50) {
    script_.runs.clear();
    script_.renewed = 0;
    script_.failures = failures;
    const StageReport report = search_.seek(q_.get(), second, max_iterations);
    EXPECT_EQ(objective_.aim(), Aim::minimum);
    EXPECT_EQ(objective_.proximal().value(q_.get()), 0.0);
    EXPECT_EQ(script_.accepted, 0.0);
    return report;
  }

  test::AnyEquation equation_{{}, true};
  SolverStatistics statistics_;
  Objective objective_{equation_, statistics_};
  Handle<Vec> q_ = equation_.filled(1.0);
  Script script_{objective_};
  EquilibriumSearch search_{objective_, script_, statistics_, 1e-8};
};

TEST_F(EquilibriumSearches, BeginAtAMinimumNearby) {
  const StageReport report = stage(0);
  EXPECT_EQ(report.outcome, StageOutcome::converged);
  EXPECT_EQ(script_.aims(), std::vector{Aim::minimum});
  EXPECT_EQ(script_.runs[0].limit, 8);
  EXPECT_EQ(script_.renewed, 0);
  EXPECT_EQ(report.newton_iterations, 3);
}

TEST_F(EquilibriumSearches, TakeWholeStepsWhereBodiesAreSlender) {
  EquilibriumSearch slender(objective_, script_, statistics_, 1e-8, Slenderness::some);
  script_.failures = 1;
  EXPECT_EQ(slender.seek(q_.get(), nullptr, 50).outcome, StageOutcome::converged);
  EXPECT_EQ(script_.aims(), (std::vector{Aim::minimum, Aim::whole_steps}));
  // The next stage begins with what has helped.
  script_.runs.clear();
  script_.failures = 0;
  slender.seek(q_.get(), nullptr, 50);
  EXPECT_EQ(script_.aims(), std::vector{Aim::whole_steps});
  // An equilibrium that is not stable does not count.
  script_.runs.clear();
  script_.finds_minimum = false;
  EXPECT_EQ(slender.seek(q_.get(), nullptr, 50).outcome, StageOutcome::converged);
  EXPECT_EQ(script_.aims(), (std::vector{Aim::whole_steps, Aim::minimum}));
}

TEST_F(EquilibriumSearches, ThenFollowAnyEquilibrium) {
  const StageReport report = stage(1);
  EXPECT_EQ(script_.aims(), (std::vector{Aim::minimum, Aim::any_equilibrium}));
  EXPECT_EQ(script_.renewed, 1);
  EXPECT_EQ(report.newton_iterations, 8 + 3);
  EXPECT_EQ(report.linear_iterations, 2 + 2);
  EXPECT_EQ(statistics_.unstable_stages, 0);
}

TEST_F(EquilibriumSearches, TryASecondGuessAndAMinimumFartherAway) {
  const Handle<Vec> second = equation_.filled(2.0);
  const StageReport report = stage(3, second.get());
  EXPECT_EQ(script_.aims(), (std::vector{Aim::minimum, Aim::any_equilibrium, Aim::any_equilibrium, Aim::minimum}));
  EXPECT_EQ(script_.runs[3].limit, 50 - 3 * 8);
  EXPECT_EQ(report.outcome, StageOutcome::converged);
  stage(2);
  EXPECT_EQ(script_.aims(), (std::vector{Aim::minimum, Aim::any_equilibrium, Aim::minimum}));
}

TEST_F(EquilibriumSearches, PreferWhatLedToTheEquilibriumBefore) {
  script_.finds_minimum = false;
  stage(1);
  EXPECT_EQ(statistics_.unstable_stages, 1);
  EXPECT_EQ(search_.first_aim(), Aim::any_equilibrium);
  stage(0);
  EXPECT_EQ(script_.aims(), std::vector{Aim::any_equilibrium});
  script_.finds_minimum = true;
  stage(0);
  EXPECT_EQ(search_.first_aim(), Aim::minimum);
  stage(0);
  EXPECT_EQ(script_.aims(), std::vector{Aim::minimum});
}

TEST_F(EquilibriumSearches, KeepToTheLimitOfIterations) {
  const StageReport report = stage(100, nullptr, 12);
  EXPECT_EQ(report.outcome, StageOutcome::retry);
  EXPECT_EQ(report.newton_iterations, 12);
  EXPECT_EQ(script_.aims(), (std::vector{Aim::minimum, Aim::any_equilibrium}));
}

// Two failures make as much trouble as it takes; the third stage descends, by runs of eight iterations.
TEST_F(EquilibriumSearches, DescendWhereShorterStepsHaveNotHelped) {
  for (int k = 0; k < 2; ++k) {
    stage(100);
    EXPECT_EQ(script_.runs.size(), 3u);
  }
  const StageReport report = stage(2);
  EXPECT_EQ(report.outcome, StageOutcome::converged);
  EXPECT_GT(script_.runs.size(), 4u);
  for (std::size_t i = 2; i + 1 < script_.runs.size(); ++i) EXPECT_EQ(script_.runs[i].limit, 8) << i;
  EXPECT_EQ(script_.runs.back().limit, 50);
  EXPECT_GE(script_.renewed, static_cast<int>(script_.runs.size()) - 2);

  // Forgotten, trouble begins again.
  stage(100);
  search_.forget();
  stage(100);
  EXPECT_EQ(script_.runs.size(), 3u);
}

}  // namespace
}  // namespace pliant::test_equilibrium_search
