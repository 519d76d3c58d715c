// What is tried in which order where there is no potential, on a scripted iteration.
#include "solver/root_search.hpp"
#include "solver/scripted_iteration.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_root_search {
namespace {

using test::Script;

struct Search {
  explicit Search(bool is_static = false) : equation({"residual"}, is_static) {
    objective.begin_stage({.q0 = q.get()});
  }
  StageReport stage(std::size_t failures, int max_iterations = 50) {
    script.runs.clear();
    script.failures = failures;
    const StageReport report = search.seek(q.get(), max_iterations);
    EXPECT_EQ(objective.aim(), objective.usual_aim());
    return report;
  }

  test::AnyEquation equation;
  SolverStatistics statistics;
  Objective objective{equation, statistics};
  Handle<Vec> q = equation.filled(1.0);
  Script script{objective};
  RootSearch search{objective, script};
};

using Aims = std::vector<Aim>;

TEST(RootSearches, BeginWithDampedSteps) {
  Search search;
  EXPECT_EQ(search.stage(0).newton_iterations, 3);
  EXPECT_EQ(search.script.aims(), Aims{Aim::root});
}

TEST(RootSearches, TryWholeStepsThenDescent) {
  Search search;
  EXPECT_EQ(search.stage(2).outcome, StageOutcome::converged);
  EXPECT_EQ(search.script.aims(), (Aims{Aim::root, Aim::whole_steps, Aim::descent}));
  // The next stage begins with what has helped.
  EXPECT_EQ(search.stage(1).outcome, StageOutcome::converged);
  EXPECT_EQ(search.script.aims(), (Aims{Aim::descent, Aim::root}));
  search.search.forget();
  search.stage(0);
  EXPECT_EQ(search.script.aims(), Aims{Aim::root});
}

TEST(RootSearches, TryDampedStepsAgain) {
  Search search;
  const auto first_of_stage = [&](std::size_t failures) {
    EXPECT_EQ(search.stage(failures).outcome, StageOutcome::converged);
    return search.script.aims().front();
  };
  // What has helped is the first kind of 2 stages, then, as damped steps fail again, of 4, and so on.
  EXPECT_EQ(first_of_stage(2), Aim::root);
  for (const int patience : {2, 4, 8, 16, 32, 32}) {
    for (int k = 0; k < patience; ++k) EXPECT_EQ(first_of_stage(0), Aim::descent);
    EXPECT_EQ(first_of_stage(2), Aim::root);
  }
  for (int k = 0; k < 32; ++k) EXPECT_EQ(first_of_stage(0), Aim::descent);
  // Where they help, nothing is left of that.
  EXPECT_EQ(first_of_stage(0), Aim::root);
  EXPECT_EQ(first_of_stage(2), Aim::root);
  for (int k = 0; k < 2; ++k) EXPECT_EQ(first_of_stage(0), Aim::descent);
  EXPECT_EQ(first_of_stage(0), Aim::root);
}

TEST(RootSearches, TakeTurnsUntilTheirIterationsAreSpent) {
  Search search;
  const StageReport report = search.stage(1000, 12);
  EXPECT_EQ(report.outcome, StageOutcome::converged);  // a single run: too few iterations for several kinds
  const StageReport failed = search.stage(1000, 13);
  EXPECT_EQ(failed.outcome, StageOutcome::retry);
  EXPECT_EQ(search.script.aims(),
            (Aims{Aim::root, Aim::whole_steps, Aim::descent, Aim::root, Aim::descent, Aim::root, Aim::root}));
  // Damped steps go on where descent has ended, and descent where it had ended: only new kinds begin anew.
  EXPECT_EQ(search.script.renewed, 4);
}

TEST(RootSearches, ContinueWhatConverges) {
  Search search;
  search.script.converges = true;
  EXPECT_EQ(search.stage(1).outcome, StageOutcome::converged);
  EXPECT_EQ(search.script.aims(), (Aims{Aim::root, Aim::root}));
  EXPECT_EQ(search.script.renewed, 0);
}

TEST(RootSearches, DoNotDescendWithoutInertia) {
  Search search(true);
  EXPECT_EQ(search.stage(1000).outcome, StageOutcome::retry);
  EXPECT_EQ(search.script.aims(), (Aims{Aim::whole_steps, Aim::root}));
}

}  // namespace
}  // namespace pliant::test_root_search
