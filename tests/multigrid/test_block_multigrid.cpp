#include "multigrid/block_multigrid.hpp"
#include "multigrid/lattice.hpp"
#include "petsc/array_view.hpp"
#include "petsc/callback.hpp"

#include <gtest/gtest.h>

namespace pliant {
namespace {

PetscErrorCode apply_multigrid(PC pc, Vec b, Vec x) {
  return CallbackGuard().run([&] {
    void* multigrid = nullptr;
    check(PCShellGetContext(pc, &multigrid));
    static_cast<BlockMultigrid*>(multigrid)->apply(b, x);
  });
}

/// Iterations of conjugate gradients to eight digits, and whether they got there.
int iterations(Mat K, BlockMultigrid& multigrid) {
  Handle<KSP> ksp;
  Handle<Vec> b, x;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
  check(KSPSetOperators(ksp.get(), K, K));
  check(KSPSetType(ksp.get(), KSPCG));
  check(KSPSetNormType(ksp.get(), KSP_NORM_UNPRECONDITIONED));
  check(KSPSetTolerances(ksp.get(), 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 200));
  PC pc = nullptr;
  check(KSPGetPC(ksp.get(), &pc));
  check(PCSetType(pc, PCSHELL));
  check(PCShellSetContext(pc, &multigrid));
  check(PCShellSetApply(pc, apply_multigrid));
  check(MatCreateVecs(K, x.out(), b.out()));
  check(VecSet(b.get(), 1.0));
  check(KSPSolve(ksp.get(), b.get(), x.get()));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt number = 0;
  check(KSPGetConvergedReason(ksp.get(), &reason));
  check(KSPGetIterationNumber(ksp.get(), &number));
  return reason > 0 ? static_cast<int>(number) : 1000;
}

TEST(BlockMultigrid, IterationsHardlyGrowWithTheSize) {
  const Lattice small(PETSC_COMM_WORLD, 8, 8, 8), large(PETSC_COMM_WORLD, 16, 16, 16);
  const auto of_small = BlockMultigrid::make(small.K()), of_large = BlockMultigrid::make(large.K());
  ASSERT_TRUE(of_small && of_large);
  EXPECT_GE(of_large->num_levels(), 2);
  EXPECT_LT(of_large->operator_complexity(), 1.6);
  const int few = iterations(small.K(), *of_small), many = iterations(large.K(), *of_large);
  EXPECT_LE(few, 20);
  EXPECT_LE(many, few + 8);
}

TEST(BlockMultigrid, TheScaleOfTheMatrixDoesNotMatter) {
  const Lattice usual(PETSC_COMM_WORLD, 12, 6, 6), weak(PETSC_COMM_WORLD, 12, 6, 6, 1e-25),
      stiff(PETSC_COMM_WORLD, 12, 6, 6, 1e30);
  const int expected = iterations(usual.K(), *BlockMultigrid::make(usual.K()));
  EXPECT_LE(expected, 30);
  // Eliminated rows have ones on their diagonals.
  EXPECT_LE(iterations(weak.K(), *BlockMultigrid::make(weak.K())), expected + 2);
  EXPECT_LE(iterations(stiff.K(), *BlockMultigrid::make(stiff.K())), expected + 2);
}

TEST(BlockMultigrid, IsSymmetric) {
  const Lattice lattice(PETSC_COMM_WORLD, 9, 8, 7);
  const auto multigrid = BlockMultigrid::make(lattice.K());
  Handle<Vec> x, y, Mx, My;
  check(MatCreateVecs(lattice.K(), x.out(), y.out()));
  check(MatCreateVecs(lattice.K(), Mx.out(), My.out()));
  check(VecSetRandom(x.get(), nullptr));
  check(VecSetRandom(y.get(), nullptr));
  check(VecShift(y.get(), -0.5));
  multigrid->apply(x.get(), Mx.get());
  multigrid->apply(y.get(), My.get());
  PetscScalar left = 0.0, right = 0.0, size = 0.0;
  check(VecDot(Mx.get(), y.get(), &left));
  check(VecDot(x.get(), My.get(), &right));
  check(VecDot(Mx.get(), x.get(), &size));
  EXPECT_NEAR(left, right, 1e-4 * size);
  EXPECT_GT(size, 0.0);
}

TEST(BlockMultigrid, TakesOtherValuesOfTheSamePattern) {
  const Lattice lattice(PETSC_COMM_WORLD, 10, 9, 8);
  const auto multigrid = BlockMultigrid::make(lattice.K());
  const int before = iterations(lattice.K(), *multigrid);
  check(MatScale(lattice.K(), 7.0));
  EXPECT_TRUE(multigrid->set_up(lattice.K()));
  EXPECT_NEAR(iterations(lattice.K(), *multigrid), before, 1);
  Handle<Vec> b, x;
  check(MatCreateVecs(lattice.K(), x.out(), b.out()));
  check(VecZeroEntries(b.get()));
  multigrid->apply(b.get(), x.get());
  PetscReal size = 1.0;
  check(VecNorm(x.get(), NORM_2, &size));
  EXPECT_EQ(size, 0.0);
}

TEST(BlockMultigrid, OtherMatricesAreLeftToOthers) {
  Handle<Mat> scalars;
  check(MatCreateAIJ(PETSC_COMM_WORLD, 4, 4, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr, scalars.out()));
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(scalars.get(), &begin, &end));
  for (PetscInt row = begin; row < end; ++row) check(MatSetValue(scalars.get(), row, row, 1.0, INSERT_VALUES));
  check(MatAssemblyBegin(scalars.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(scalars.get(), MAT_FINAL_ASSEMBLY));
  EXPECT_EQ(BlockMultigrid::make(scalars.get()), nullptr);
  const Lattice lattice(PETSC_COMM_WORLD, 4, 4, 4);
  check(MatSetNearNullSpace(lattice.K(), nullptr));
  EXPECT_EQ(BlockMultigrid::make(lattice.K()), nullptr);
}

}  // namespace
}  // namespace pliant
