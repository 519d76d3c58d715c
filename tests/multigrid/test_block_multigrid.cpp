#include "multigrid/block_multigrid.hpp"
#include "multigrid/lattice.hpp"
#include "petsc/array_view.hpp"
#include "petsc/callback.hpp"

#include <vector>

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

/// Whether constraints make this entry a slave, which keeps nothing but its diagonal.
bool is_slave(PetscInt entry) {
  return entry / 3 % 4 == 1 && entry % 3 == entry / 12 % 3;
}

/// K without what belongs to slaves: the pattern too.
Handle<Mat> without_slaves(Mat K) {
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(K, &begin, &end));
  std::vector<PetscInt> offsets{0}, columns;
  std::vector<PetscScalar> values;
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt count = 0;
    const PetscInt* of_row = nullptr;
    const PetscScalar* entries = nullptr;
    check(MatGetRow(K, row, &count, &of_row, &entries));
    for (PetscInt k = 0; k < count; ++k) {
      if (of_row[k] != row && (is_slave(row) || is_slave(of_row[k]))) continue;
      columns.push_back(of_row[k]);
      values.push_back(entries[k]);
    }
    check(MatRestoreRow(K, row, &count, &of_row, &entries));
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  Handle<Mat> result;
  check(MatCreateMPIAIJWithArrays(PETSC_COMM_WORLD, end - begin, end - begin, PETSC_DETERMINE, PETSC_DETERMINE,
                                  offsets.data(), columns.data(), values.data(), result.out()));
  MatNullSpace space = nullptr;
  PetscInt number = 0;
  const Vec* modes = nullptr;
  check(MatGetNearNullSpace(K, &space));
  check(MatNullSpaceGetVecs(space, nullptr, &number, &modes));
  std::vector<Handle<Vec>> copies;
  std::vector<Vec> raw;
  for (PetscInt m = 0; m < number; ++m) {
    check(VecDuplicate(modes[m], copies.emplace_back().out()));
    check(VecCopy(modes[m], copies.back().get()));
    {
      const ArrayView mode(copies.back().get());
      for (PetscInt row = begin; row < end; ++row) {
        if (is_slave(row)) mode[row - begin] = 0.0;
      }
    }
    for (const Vec before : raw) {
      PetscScalar product = 0.0;
      check(VecDot(copies.back().get(), before, &product));
      check(VecAXPY(copies.back().get(), -product, before));
    }
    check(VecNormalize(copies.back().get(), nullptr));
    raw.push_back(copies.back().get());
  }
  Handle<MatNullSpace> of_result;
  check(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, number, raw.data(), of_result.out()));
  check(MatSetNearNullSpace(result.get(), of_result.get()));
  return result;
}

TEST(MatrixBlocks, AreZeroWhereNothingIsStored) {
  const Lattice lattice(PETSC_COMM_WORLD, 5, 4, 3);
  const Handle<Mat> K = without_slaves(lattice.K());
  const auto blocks = MatrixBlocks::of(K.get());
  ASSERT_TRUE(blocks);
  const BlockCsr pattern = blocks->pattern();
  const Halo halo = blocks->make_halo();
  PetscInt num_stored = 0, num_partial = 0;
  for (int row = 0; row < pattern.num_rows(); ++row) {
    for (std::size_t k = pattern.begin(row); k < pattern.end(row); ++k) {
      double block[9];
      blocks->read(row, k - pattern.begin(row), block);
      const PetscInt i = 3 * halo.global(row), j = 3 * halo.global(pattern.columns[k]);
      int num_zero = 0;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          const PetscInt at = i + r, column = j + c;
          PetscScalar expected = 0.0;
          check(MatGetValues(K.get(), 1, &at, 1, &column, &expected));
          EXPECT_EQ(block[3 * c + r], expected) << at << ' ' << column;
          if (expected != 0.0) ++num_stored;
          if (is_slave(at) || is_slave(column)) ++num_zero;
        }
      }
      if (num_zero > 0) ++num_partial;
    }
  }
  EXPECT_GT(num_partial, 0);
  PetscInt num_not_zero = 0, begin = 0, end = 0;
  check(MatGetOwnershipRange(K.get(), &begin, &end));
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt count = 0;
    const PetscScalar* entries = nullptr;
    check(MatGetRow(K.get(), row, &count, nullptr, &entries));
    for (PetscInt k = 0; k < count; ++k) num_not_zero += entries[k] != 0.0 ? 1 : 0;
    check(MatRestoreRow(K.get(), row, &count, nullptr, &entries));
  }
  EXPECT_EQ(num_stored, num_not_zero);  // none is missing
}

TEST(BlockMultigrid, TakesWhatConstraintsLeave) {
  const Lattice lattice(PETSC_COMM_WORLD, 12, 8, 8);
  const Handle<Mat> K = without_slaves(lattice.K());
  const auto of_all = BlockMultigrid::make(lattice.K()), of_rest = BlockMultigrid::make(K.get());
  ASSERT_TRUE(of_all && of_rest);
  EXPECT_GE(of_rest->num_levels(), 2);
  EXPECT_LE(iterations(K.get(), *of_rest), iterations(lattice.K(), *of_all) + 5);
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
