// When an iterate is a solution, on an equation of one unknown with scripted forces.
#include "solver/convergence.hpp"
#include "solver/small_equation.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_convergence {
namespace {

using Verdict = Convergence::Verdict;

/// Forces and rounding errors as the test says.
class Forces final : public test::SmallEquation {
 public:
  Forces()
      : SmallEquation(MPI_COMM_WORLD,
                      {1, [](auto) { return std::vector{0.0}; }, [](auto) { return std::vector{1.0}; }}) {}
  double force_scale(Vec) override { return forces; }
  double rounding_floor(Vec) const override { return floor; }

  double forces = 100.0, floor = 0.0;
};

class ConvergenceTest : public ::testing::Test {
 protected:
  ConvergenceTest() {
    convergence_.begin_stage();
    convergence_.measure_guess(q_.get());
  }
  Verdict judge(int iteration, double residual, bool line_search_is_at_rounding = false) {
    return convergence_.judge(iteration, residual, q_.get(), line_search_is_at_rounding);
  }

  Forces equation_;
  SolverStatistics statistics_;
  Objective objective_{equation_, statistics_};
  Handle<Vec> q_ = equation_.filled(1.0);
  int reassembled_ = 0;
  Convergence convergence_{objective_, {.relative = 1e-6}, statistics_, [this](Vec) { ++reassembled_; }};
};

TEST_F(ConvergenceTest, ComparesTheResidualWithTheForces) {
  EXPECT_DOUBLE_EQ(convergence_.target(), 1e-4);
  EXPECT_EQ(judge(0, 1.0), Verdict::iterating);
  EXPECT_EQ(judge(1, 1.01e-4), Verdict::iterating);
  EXPECT_EQ(judge(2, 0.99e-4), Verdict::converged);
  EXPECT_EQ(statistics_.rounding_stops, 0);
}

TEST_F(ConvergenceTest, NothingConvergesToNotANumber) {
  EXPECT_EQ(judge(0, std::numeric_limits<double>::quiet_NaN()), Verdict::not_a_number);
  EXPECT_EQ(judge(1, std::numeric_limits<double>::infinity()), Verdict::not_a_number);
}

// The guess was stretched: its forces were a thousand times those that balance at the solution.
TEST_F(ConvergenceTest, TakesTheForcesAtTheIterateWhereTheyAreMuchLess) {
  judge(0, 1.0);
  equation_.forces = 0.1;
  EXPECT_EQ(judge(1, 0.99e-4), Verdict::iterating);
  EXPECT_TRUE(convergence_.has_met_first_target());
  EXPECT_DOUBLE_EQ(convergence_.target(), 1e-7);
  EXPECT_EQ(judge(2, 0.99e-7), Verdict::converged);
  // Another run judges by what it meets itself.
  judge(0, 1.0);
  EXPECT_FALSE(convergence_.has_met_first_target());
}

TEST_F(ConvergenceTest, StopsAtRoundingErrorsAndCountsThem) {
  equation_.floor = 1e-3;
  EXPECT_EQ(judge(0, 3e-3), Verdict::iterating);  // a start is no result
  EXPECT_EQ(judge(1, 3e-4), Verdict::at_rounding);
  EXPECT_EQ(statistics_.rounding_stops, 1);
  EXPECT_DOUBLE_EQ(statistics_.worst_rounding, 3e-6);
  EXPECT_EQ(reassembled_, 1);  // more than a millionth is left: the floor deserves a second look
}

// A residual that has hardly fallen since the start was no rounding error there.
TEST_F(ConvergenceTest, RoundingErrorsWereLessAtASmallerStart) {
  const Handle<Vec> small = equation_.filled(1e-3);
  equation_.floor = 1e-3;
  EXPECT_EQ(convergence_.judge(0, 3.9e-3, small.get(), false), Verdict::iterating);
  EXPECT_EQ(convergence_.judge(1, 3.8e-3, q_.get(), false), Verdict::iterating);
}

TEST_F(ConvergenceTest, ARunFromASolutionMayEndAtOnce) {
  equation_.floor = 1e-3;
  convergence_.expect_solution();
  EXPECT_EQ(judge(0, 3e-3), Verdict::at_rounding);
}

// Where a mechanism cannot close, its displacements are no numbers.
TEST_F(ConvergenceTest, RoundingErrorsThatAreNoNumberHideNothing) {
  equation_.floor = std::numeric_limits<double>::quiet_NaN();
  judge(0, 10.0);
  EXPECT_EQ(judge(1, 0.5), Verdict::iterating);
  EXPECT_EQ(statistics_.rounding_stops, 0);
}

TEST_F(ConvergenceTest, BelievesALineSearchThatFoundRoundingErrors) {
  judge(0, 1.0);
  EXPECT_EQ(judge(1, 0.5, true), Verdict::at_rounding);
  EXPECT_EQ(statistics_.rounding_stops, 1);
}

TEST_F(ConvergenceTest, AcceptsMoreOnTheWayOfADescent) {
  convergence_.accept(0.5);
  judge(0, 1.0);
  EXPECT_EQ(judge(1, 0.4), Verdict::converged);
  convergence_.accept(0.0);
  EXPECT_EQ(judge(1, 0.4), Verdict::iterating);
}

}  // namespace
}  // namespace pliant::test_convergence
