// When a factor is kept, on scripted solves.
#include "solver/factor_policy.hpp"

#include <gtest/gtest.h>

namespace pliant::test_factor_policy {
namespace {

using Factor = FactorPolicy::Factor;
using Factored = FactorPolicy::Factored;
using Solver = FactorPolicy::Solver;

constexpr double cost = 10.0;

/// With a factor, two iterations per digit when it was fresh.
FactorPolicy with_factor() {
  FactorPolicy policy(Solver::iterative);
  policy.note_set_up(SetUp::sound);
  policy.note_solve({.iterations = 6, .digits = 3.0, .cost_of_set_up = cost}, Factor::own);
  return policy;
}

TEST(FactorPolicy, WantsAFactorBeforeTheFirst) {
  FactorPolicy policy(Solver::iterative);
  EXPECT_TRUE(policy.wants_factor());
  policy.note_set_up(SetUp::sound);
  EXPECT_FALSE(policy.wants_factor());
}

TEST(FactorPolicy, KeepsAFactorThatIsAsGoodAsAFreshOne) {
  FactorPolicy policy = with_factor();
  for (int k = 0; k < 1000; ++k) {
    policy.note_solve({.iterations = 7, .digits = 3.0, .cost_of_set_up = cost}, Factor::kept);
  }
  EXPECT_FALSE(policy.wants_factor());
}

// Four iterations more than three digits take, less one that is forgiven: the fourth solve exceeds the cost of ten.
TEST(FactorPolicy, RenewsWhenTheExcessCostsAFactorization) {
  FactorPolicy policy = with_factor();
  for (int k = 0; k < 3; ++k) {
    policy.note_solve({.iterations = 10, .digits = 3.0, .cost_of_set_up = cost}, Factor::kept);
    EXPECT_FALSE(policy.wants_factor()) << k;
  }
  policy.note_solve({.iterations = 10, .digits = 3.0, .cost_of_set_up = cost}, Factor::kept);
  EXPECT_TRUE(policy.wants_factor());
  // A new factor starts with no excess.
  policy.note_set_up(SetUp::sound);
  policy.note_solve({.iterations = 10, .digits = 3.0, .cost_of_set_up = cost}, Factor::kept);
  EXPECT_FALSE(policy.wants_factor());
}

// Inexact solves are compared with fresh ones to as many digits.
TEST(FactorPolicy, ComparesSolvesDigitByDigit) {
  FactorPolicy loose = with_factor(), tight = with_factor();
  loose.note_solve({.iterations = 15, .digits = 1.0, .cost_of_set_up = cost}, Factor::kept);
  tight.note_solve({.iterations = 15, .digits = 6.0, .cost_of_set_up = cost}, Factor::kept);
  EXPECT_TRUE(loose.wants_factor());
  EXPECT_FALSE(tight.wants_factor());
}

TEST(FactorPolicy, ADirectSolverKeepsNothing) {
  FactorPolicy policy(Solver::direct);
  policy.note_set_up(SetUp::sound);
  EXPECT_TRUE(policy.wants_factor());
  EXPECT_FALSE(policy.has_failed());
}

TEST(FactorPolicy, WantsAnotherFactorAfterAFailure) {
  FactorPolicy policy = with_factor();
  policy.note_set_up(SetUp::singular);
  EXPECT_TRUE(policy.has_failed());
  EXPECT_TRUE(policy.wants_factor());
  EXPECT_FALSE(policy.lacks_memory());
  policy.note_set_up(SetUp::sound);
  EXPECT_FALSE(policy.has_failed());
  EXPECT_FALSE(policy.wants_factor());
  policy.note_failure();
  EXPECT_TRUE(policy.has_failed());
  EXPECT_TRUE(policy.wants_factor());
}

TEST(FactorPolicy, ForgetsALackOfMemoryWithTheStage) {
  FactorPolicy policy = with_factor();
  policy.note_set_up(SetUp::out_of_memory);
  EXPECT_TRUE(policy.lacks_memory());
  EXPECT_TRUE(policy.has_failed());
  policy.begin_stage();
  EXPECT_FALSE(policy.lacks_memory());
  EXPECT_TRUE(policy.wants_factor());
}

TEST(FactorPolicy, OnlyAFactorOfTheVeryMatrixCanBePoor) {
  const auto is_poor = [](int iterations, Factor factor, Factored factored) {
    return FactorPolicy::is_poor({.iterations = iterations, .digits = 4.0}, factor, factored);
  };
  EXPECT_FALSE(is_poor(40, Factor::own, Factored::whole));
  EXPECT_TRUE(is_poor(41, Factor::own, Factored::whole));
  EXPECT_FALSE(is_poor(1000, Factor::kept, Factored::whole));
  EXPECT_FALSE(is_poor(15, Factor::own, Factored::symmetric_part));
  EXPECT_TRUE(is_poor(16, Factor::own, Factored::symmetric_part));
  EXPECT_FALSE(is_poor(1000, Factor::kept, Factored::symmetric_part));
  EXPECT_FALSE(is_poor(24, Factor::own, Factored::nothing));
  EXPECT_TRUE(is_poor(25, Factor::own, Factored::nothing));
  EXPECT_FALSE(is_poor(1000, Factor::kept, Factored::nothing));
}

TEST(FactorPolicy, MultigridMayTakeAFewIterationsForFewDigits) {
  EXPECT_FALSE(FactorPolicy::is_poor({.iterations = 18, .digits = 0.5}, Factor::own, FactorPolicy::Factored::nothing));
  EXPECT_TRUE(FactorPolicy::is_poor({.iterations = 19, .digits = 0.5}, Factor::own, FactorPolicy::Factored::nothing));
}

TEST(FactorPolicy, RenewsOnRequest) {
  FactorPolicy policy = with_factor();
  policy.renew();
  EXPECT_TRUE(policy.wants_factor());
}

}  // namespace
}  // namespace pliant::test_factor_policy
