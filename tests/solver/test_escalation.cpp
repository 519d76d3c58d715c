// The fallback sequence: every state and what leads from it.
#include "solver/escalation.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_escalation {
namespace {

using State = Escalation::State;
using Permission = Escalation::Permission;

/// The machine, brought to a state as a linear system would.
Escalation in(State state) {
  Escalation escalation;
  escalation.begin();
  switch (state) {
    case State::kept_factor:
      break;
    case State::fresh_factor:
      escalation.factorized();
      break;
    case State::made_definite:
      escalation.factorized();
      escalation.shifted();
      break;
    case State::projected:
      escalation.projected();
      break;
    case State::projected_and_shifted:
      escalation.projected();
      escalation.shifted();
      break;
    case State::smaller_step:
      escalation.escalate(Permission::nothing);
      break;
  }
  EXPECT_EQ(escalation.state(), state);
  return escalation;
}

const std::vector<State> all{State::kept_factor, State::fresh_factor,          State::made_definite,
                             State::projected,   State::projected_and_shifted, State::smaller_step};

TEST(Escalation, GoesThroughTheWholeSequence) {
  Escalation escalation;
  std::vector<State> states;
  while (escalation.state() != State::smaller_step) states.push_back(escalation.escalate(Permission::anything));
  EXPECT_EQ(states,
            (std::vector{State::fresh_factor, State::projected, State::projected_and_shifted, State::smaller_step}));
}

TEST(Escalation, AHessianWithProjectedBarriersIsProjectedNext) {
  for (const State state : {State::fresh_factor, State::made_definite}) {
    Escalation escalation = in(state);
    escalation.barriers_projected();
    EXPECT_EQ(escalation.state(), State::made_definite);
    escalation.factorized();
    EXPECT_EQ(escalation.escalate(Permission::anything), State::projected);
  }
}

TEST(Escalation, AHessianMadeDefiniteIsProjectedNext) {
  EXPECT_EQ(in(State::made_definite).escalate(Permission::anything), State::projected);
}

TEST(Escalation, StaysWithTheExactHessianWhereAnyEquilibriumWillDo) {
  Escalation escalation;
  EXPECT_EQ(escalation.escalate(Permission::exact_hessian), State::fresh_factor);
  EXPECT_EQ(escalation.escalate(Permission::exact_hessian), State::smaller_step);
}

TEST(Escalation, HasNothingLeftWithoutMemory) {
  for (const State state : all) EXPECT_EQ(in(state).escalate(Permission::nothing), State::smaller_step);
}

TEST(Escalation, NeverLeadsBack) {
  for (const Permission permission : {Permission::anything, Permission::exact_hessian, Permission::nothing}) {
    for (const State state : all) {
      Escalation escalation = in(state);
      State before = state;
      for (int k = 0; k < 4; ++k) {
        const State after = escalation.escalate(permission);
        EXPECT_TRUE(after > before || (after == before && after == State::smaller_step));
        before = after;
      }
      EXPECT_EQ(before, State::smaller_step);
    }
  }
}

TEST(Escalation, BeginsAnewWithEachHessian) {
  for (const State state : all) {
    Escalation escalation = in(state);
    escalation.begin();
    EXPECT_EQ(escalation.state(), State::kept_factor);
    EXPECT_TRUE(escalation.has_kept_factor());
  }
}

TEST(Escalation, AFactorizationChangesOnlyWhoseFactorItIs) {
  for (const State state : all) {
    Escalation escalation = in(state);
    escalation.factorized();
    EXPECT_EQ(escalation.state(), state == State::kept_factor ? State::fresh_factor : state);
    EXPECT_FALSE(escalation.has_kept_factor());
  }
}

TEST(Escalation, KnowsWhatWasDoneToTheHessian) {
  for (const State state : all) {
    const Escalation escalation = in(state);
    EXPECT_EQ(escalation.is_projected(), state == State::projected || state == State::projected_and_shifted);
    EXPECT_EQ(escalation.is_shifted(), state == State::made_definite || state == State::projected_and_shifted);
  }
  Escalation twice = in(State::made_definite);
  twice.shifted();
  EXPECT_EQ(twice.state(), State::made_definite);
  twice.projected();
  EXPECT_EQ(twice.state(), State::projected);
}

}  // namespace
}  // namespace pliant::test_escalation
