#include "multigrid/block_multigrid.hpp"
#include "multigrid/lattice.hpp"
#include "petsc/array_view.hpp"
#include "solver/several_systems.hpp"
#include "solver/single_factorization.hpp"

#include <array>

#include <gtest/gtest.h>

namespace pliant {
namespace {

/// Three systems with other right-hand sides, the second of which is small.
class SeveralSystemsOfLattice : public testing::Test {
 protected:
  SeveralSystemsOfLattice() {
    for (std::size_t n = 0; n < r_.size(); ++n) {
      check(MatCreateVecs(K(), y_[n].out(), r_[n].out()));
      check(VecSetRandom(r_[n].get(), nullptr));
      check(VecShift(r_[n].get(), 0.1 * static_cast<double>(n)));
      r_list_.push_back(r_[n].get());
      y_list_.push_back(y_[n].get());
    }
    check(VecScale(r_[1].get(), 1e-12));
  }
  Mat K() const { return lattice_.K(); }

  void expect_solutions(double part) const {
    Handle<Vec> left;
    check(MatCreateVecs(K(), left.out(), nullptr));
    for (std::size_t n = 0; n < r_.size(); ++n) {
      check(MatMult(K(), y_[n].get(), left.get()));
      check(VecAXPY(left.get(), -1.0, r_[n].get()));
      PetscReal size = 0.0, of_r = 0.0;
      check(VecNorm(left.get(), NORM_2, &size));
      check(VecNorm(r_[n].get(), NORM_2, &of_r));
      EXPECT_LE(size, 1.01 * part * of_r) << "system " << n;
    }
  }

  Lattice lattice_{PETSC_COMM_WORLD, 12, 7, 6};
  std::array<Handle<Vec>, 3> r_, y_;
  std::vector<Vec> r_list_, y_list_;
  std::array<Vec, 3> none_{};
  SeveralSystems systems_;
};

TEST_F(SeveralSystemsOfLattice, AreSolvedWithMultigridEachToItsDigits) {
  const auto multigrid = BlockMultigrid::make(K());
  const auto inverse = [&](std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
    multigrid->apply(b, x);
    return true;
  };
  const auto cost = systems_.solve(K(), inverse, r_list_, none_, y_list_, 1e-9, 60);
  ASSERT_TRUE(cost);
  EXPECT_LE(cost->iterations, 30);
  EXPECT_NEAR(cost->digits, 9.0, 1e-6);
  expect_solutions(1e-9);
  EXPECT_FALSE(systems_.solve(K(), inverse, r_list_, none_, y_list_, 1e-9, 2));
}

TEST_F(SeveralSystemsOfLattice, AreSolvedWithAFactorization) {
  SingleFactorization factors(Symmetry::symmetric);
  ASSERT_EQ(factors.factorize(K()), SetUp::sound);
  const auto inverse = [&](std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
    return factors.solve(b, x);
  };
  const auto cost = systems_.solve(K(), inverse, r_list_, none_, y_list_, 1e-9, 60);
  ASSERT_TRUE(cost);
  EXPECT_LE(cost->iterations, 3);
  expect_solutions(1e-9);
}

TEST_F(SeveralSystemsOfLattice, NeedFewerIterationsFromAGuess) {
  SingleFactorization factors(Symmetry::symmetric);
  ASSERT_EQ(factors.factorize(K()), SetUp::sound);
  const auto inverse = [&](std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
    return factors.solve(b, x);
  };
  ASSERT_TRUE(systems_.solve(K(), inverse, r_list_, none_, y_list_, 1e-9, 60));
  std::array<Handle<Vec>, 3> left;
  std::vector<Vec> residuals, changes;
  std::array<Handle<Vec>, 3> change;
  for (std::size_t n = 0; n < r_.size(); ++n) {
    check(VecDuplicate(r_list_[n], left[n].out()));
    check(VecDuplicate(r_list_[n], change[n].out()));
    check(MatMult(K(), y_list_[n], left[n].get()));
    check(VecAYPX(left[n].get(), -1.0, r_list_[n]));
    residuals.push_back(left[n].get());
    changes.push_back(change[n].get());
  }
  const auto cost = systems_.solve(K(), inverse, residuals, y_list_, changes, 1e-8, 60);
  ASSERT_TRUE(cost);
  EXPECT_EQ(cost->iterations, 0);
  ASSERT_TRUE(systems_.solve(K(), inverse, residuals, y_list_, changes, 1e-13, 60));
  for (std::size_t n = 0; n < r_.size(); ++n) check(VecAXPY(y_list_[n], 1.0, changes[n]));
  expect_solutions(1e-12);
}

TEST_F(SeveralSystemsOfLattice, OfAnIndefiniteMatrixAreNotSolved) {
  check(MatShift(K(), -1.0));
  const auto inverse = [](std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
    std::ranges::copy(b, x.begin());
    return true;
  };
  EXPECT_FALSE(systems_.solve(K(), inverse, r_list_, none_, y_list_, 1e-9, 1000));
}

}  // namespace
}  // namespace pliant
