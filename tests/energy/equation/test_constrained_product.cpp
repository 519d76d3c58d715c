// The product with matrices close to the identity, against that of the whole matrices.
#include "energy/constraint/sparse_rows.hpp"
#include "energy/equation/constrained_product.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_constrained_product {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr PetscInt num_mine = 12;

/// A number that depends on two numbers in a rough way.
double rough(PetscInt i, PetscInt j) {
  return std::sin(1.0 + 3.7 * i + 1.3 * j * j);
}

class ConstrainedProducts : public ::testing::Test {
 protected:
  ConstrainedProducts() {
    check_mpi(MPI_Comm_rank(comm, &rank_));
    check_mpi(MPI_Comm_size(comm, &size_));
    first_ = rank_ * num_mine;
    num_all_ = size_ * num_mine;
  }
  /// A band, and a column that all ranks have.
  Handle<Mat> band(double factor) const {
    SparseRows rows(num_mine);
    for (PetscInt i = 0; i < num_mine; ++i) {
      const PetscInt row = first_ + i;
      for (PetscInt column = std::max<PetscInt>(0, row - 3); column < std::min(num_all_, row + 4); ++column) {
        rows[static_cast<std::size_t>(i)][column] = factor * rough(row, column);
      }
      rows[static_cast<std::size_t>(i)][5] = factor * rough(row, 5);
    }
    return make_sparse_matrix(comm, rows);
  }
  /// Rows 4 and 5 of each rank follow row 0 of the first rank and row 7 of the last, the others are the identity's.
  Handle<Mat> map(double factor) const {
    SparseRows rows(num_mine);
    for (PetscInt i = 0; i < num_mine; ++i) {
      const PetscInt row = first_ + i;
      auto& entries = rows[static_cast<std::size_t>(i)];
      if (!is_tied(i)) {
        entries[row] = 1.0;
        continue;
      }
      entries[row] = 0.0;
      entries[0] = factor * rough(row, 1);
      entries[num_all_ - num_mine + 7] = factor * rough(row, 2);
    }
    return make_sparse_matrix(comm, rows);
  }
  /// Rows 4, 5 and 8 of each rank have entries in row 4 of the first rank, row 8 of the last and row 5 of the second,
  /// if there is one, and are themselves zero otherwise.
  Handle<Mat> dependents(double factor) const {
    SparseRows rows(num_mine);
    for (PetscInt i = 0; i < num_mine; ++i) {
      auto& entries = rows[static_cast<std::size_t>(i)];
      entries[first_ + i] = is_dependent(i) ? 0.0 : 1.0;
      if (!is_dependent(i)) continue;
      for (const PetscInt host : hosts()) entries[host] = factor * rough(first_ + i, host);
    }
    return make_sparse_matrix(comm, rows);
  }
  std::vector<PetscInt> hosts() const { return {4, num_all_ - num_mine + 8, std::min(size_ - 1, 1) * num_mine + 5}; }
  static bool is_dependent(PetscInt i) { return i == 4 || i == 5 || i == 8; }
  std::vector<char> flags(bool of_slaves) const {
    const auto all = hosts();
    std::vector<char> result(num_mine, 0);
    for (PetscInt i = 0; i < num_mine; ++i) {
      const bool is_host = std::ranges::find(all, first_ + i) != all.end();
      result[static_cast<std::size_t>(i)] = is_dependent(i) && !(of_slaves && is_host) ? 1 : 0;
    }
    return result;
  }
  static bool is_tied(PetscInt i) { return i == 4 || i == 5; }
  static std::vector<char> tied() {
    std::vector<char> flags(num_mine, 0);
    for (PetscInt i = 0; i < num_mine; ++i) flags[static_cast<std::size_t>(i)] = is_tied(i) ? 1 : 0;
    return flags;
  }
  /// |W^T A J - K|, entry by entry.
  static double difference(Mat A, Mat W, Mat J, Mat K) {
    Handle<Mat> AJ, whole;
    check(MatMatMult(A, J, MAT_INITIAL_MATRIX, PETSC_DEFAULT, AJ.out()));
    check(MatTransposeMatMult(W, AJ.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, whole.out()));
    PetscReal size = 0.0, result = 0.0;
    check(MatNorm(whole.get(), NORM_FROBENIUS, &size));
    EXPECT_GT(size, 1.0);
    check(MatAXPY(whole.get(), -1.0, K, DIFFERENT_NONZERO_PATTERN));
    check(MatNorm(whole.get(), NORM_FROBENIUS, &result));
    return result / size;
  }

  int rank_ = 0, size_ = 1;
  PetscInt first_ = 0, num_all_ = 0;
};

TEST_F(ConstrainedProducts, AreThoseOfTheWholeMatrices) {
  const auto A = band(1.0), other = band(-0.3), J = map(1.0), W = map(0.7);
  for (const Mat test : {W.get(), J.get()}) {
    ConstrainedProduct product(A.get(), test, J.get(), tied(), {});
    const Handle<Mat> K = product.make();
    for (const Mat now : {A.get(), other.get(), A.get()}) {
      product.set(now, K.get());
      EXPECT_LT(difference(now, test, J.get(), K.get()), 1e-15);
    }
  }
}

TEST_F(ConstrainedProducts, FollowTheValuesOfTheMaps) {
  const auto A = band(1.0), J = map(1.0), W = map(0.7), wider = map(1.9);
  ConstrainedProduct product(A.get(), W.get(), J.get(), tied(), {});
  const Handle<Mat> K = product.make();
  product.set(A.get(), K.get());
  check(MatCopy(wider.get(), J.get(), SAME_NONZERO_PATTERN));
  product.set(A.get(), K.get());
  EXPECT_LT(difference(A.get(), W.get(), J.get(), K.get()), 1e-15);
}

TEST_F(ConstrainedProducts, TakeRowsOfTheSameColumnsTogether) {
  const auto A = band(1.0), J = dependents(1.0), W = dependents(0.7);
  for (const Mat test : {W.get(), J.get()}) {
    ConstrainedProduct product(A.get(), test, J.get(), flags(false), flags(true), {{{4, 5, 8}, hosts()}});
    const Handle<Mat> K = product.make();
    for (int round = 0; round < 2; ++round) {
      product.set(A.get(), K.get());
      // But for the diagonal of slaves.
      Handle<Mat> without;
      check(MatDuplicate(K.get(), MAT_COPY_VALUES, without.out()));
      const auto slaves = flags(true);
      for (PetscInt i = 0; i < num_mine; ++i) {
        if (slaves[static_cast<std::size_t>(i)])
          check(MatSetValue(without.get(), first_ + i, first_ + i, 0.0, INSERT_VALUES));
      }
      check(MatAssemblyBegin(without.get(), MAT_FINAL_ASSEMBLY));
      check(MatAssemblyEnd(without.get(), MAT_FINAL_ASSEMBLY));
      EXPECT_LT(difference(A.get(), test, J.get(), without.get()), 1e-15);
    }
  }
}

TEST_F(ConstrainedProducts, HaveSizesOfTheDiagonalAtSlaves) {
  const auto A = band(-1.0), J = map(1.0);
  check(MatSetValue(A.get(), first_ + 4, first_ + 4, 0.0, INSERT_VALUES));
  check(MatAssemblyBegin(A.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(A.get(), MAT_FINAL_ASSEMBLY));
  ConstrainedProduct free(A.get(), J.get(), J.get(), tied(), {}), product(A.get(), J.get(), J.get(), tied(), tied());
  const Handle<Mat> without = free.make(), K = product.make();
  free.set(A.get(), without.get());
  product.set(A.get(), K.get());
  Handle<Vec> of_A, of_K, expected;
  check(MatCreateVecs(K.get(), of_A.out(), expected.out()));
  check(VecDuplicate(of_A.get(), of_K.out()));
  get_diagonal(A.get(), of_A.get());
  check(VecCopy(of_A.get(), of_K.get()));
  product.put_diagonal(K.get(), of_K.get());
  check(MatGetDiagonal(without.get(), expected.get()));
  const ConstArrayView all(of_A.get()), found(of_K.get()), of_others(expected.get());
  for (PetscInt i = 0; i < num_mine; ++i) {
    if (!is_tied(i)) {
      EXPECT_EQ(found[i], of_others[i]);
      continue;
    }
    EXPECT_EQ(found[i], std::abs(all[5]));  // the largest for the one that is zero
    EXPECT_GT(found[i], 0.0);
  }
}

}  // namespace
}  // namespace pliant::test_constrained_product
