#include "multigrid/galerkin.hpp"
#include "multigrid/lattice.hpp"
#include "multigrid/level.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <eigen3/Eigen/Dense>

#include <gtest/gtest.h>

namespace pliant {
namespace {

/// All of a distributed matrix of blocks, on every rank.
Eigen::MatrixXd dense(const BlockCsr& A, const Halo& rows, const Halo& columns) {
  struct Entry {
    PetscInt row, column;
    double value;
  };
  std::vector<Entry> mine;
  for (int i = 0; i < rows.num_owned(); ++i) {
    for (std::size_t k = A.begin(i); k < A.end(i); ++k) {
      for (int c = 0; c < A.width; ++c) {
        for (int r = 0; r < A.height; ++r) {
          mine.push_back({rows.global(i) * A.height + r, columns.global(A.columns[k]) * A.width + c,
                          A.block(k)[c * A.height + r]});
        }
      }
    }
  }
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows.num_global() * A.height, columns.num_global() * A.width);
  for (const Entry& entry : gathered(PETSC_COMM_WORLD, mine)) all(entry.row, entry.column) += entry.value;
  return all;
}

/// Translations and rotations, at the nodes of rank-local rows, of K's near-null space.
Modes modes_of(Mat K, int num_rows) {
  MatNullSpace space = nullptr;
  PetscInt number = 0;
  const Vec* vectors = nullptr;
  check(MatGetNearNullSpace(K, &space));
  check(MatNullSpaceGetVecs(space, nullptr, &number, &vectors));
  Modes modes;
  modes.values.resize(static_cast<std::size_t>(num_rows) * modes.block_size());
  for (int m = 0; m < number; ++m) {
    const ConstArrayView mode(vectors[m]);
    for (int e = 0; e < 3 * num_rows; ++e) modes.block(e / 3)[3 * m + e % 3] = mode[e];
  }
  return modes;
}

class Coarsened : public ::testing::Test {
 protected:
  Lattice lattice_{PETSC_COMM_WORLD, 7, 5, 4};
  std::optional<MatrixBlocks> blocks_ = MatrixBlocks::of(lattice_.K());
  Level level_{blocks_->make_halo(), blocks_->pattern()};
  bool is_positive_ = level_.take(*blocks_);
  Aggregates aggregates_ = aggregate(level_.matrix());
  Modes modes_ = modes_of(lattice_.K(), blocks_->num_rows());
};

TEST_F(Coarsened, EveryBoundNodeIsInOneAggregate) {
  for (int node = 0; node < level_.halo().num_owned(); ++node) {
    const int of = aggregates_.of_node[static_cast<std::size_t>(node)];
    bool is_bound = false;
    for (std::size_t k = level_.matrix().begin(node); k < level_.matrix().end(node); ++k) {
      const int other = level_.matrix().columns[k];
      is_bound =
          is_bound || (other != node && other < level_.halo().num_owned() && level_.matrix().block(k)[0] != 0.0F);
    }
    if (is_bound) {
      EXPECT_GE(of, 0);
    }
    EXPECT_LT(of, aggregates_.number);
  }
}

TEST_F(Coarsened, ModesAreCoarseFunctions) {
  const Modes before = modes_;
  const Modes coarse = orthonormalise(aggregates_, modes_);
  for (std::size_t i = 0; i < aggregates_.of_node.size(); ++i) {
    if (aggregates_.of_node[i] < 0) continue;
    const Eigen::Map<const Eigen::Matrix<double, 3, 6>> Q(modes_.block(static_cast<int>(i)));
    const Eigen::Map<const Eigen::Matrix<double, 6, 6>> R(coarse.block(aggregates_.of_node[i]));
    const Eigen::Map<const Eigen::Matrix<double, 3, 6>> B(before.block(static_cast<int>(i)));
    EXPECT_LT((Q * R - B).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST_F(Coarsened, TheProductIsThatOfTheDenseMatrices) {
  EXPECT_TRUE(is_positive_);
  (void)orthonormalise(aggregates_, modes_);
  GalerkinProduct product(level_.matrix(), level_.halo(),
                          smoothed_prolongation(level_.matrix(), level_.halo(), level_.inverse_diagonal(),
                                                level_.largest_eigenvalue(), aggregates_, modes_));
  for (int repeated = 0; repeated < 2; ++repeated) {
    product.compute(level_.matrix(), *blocks_);
    Level coarse(product.coarse(), product.pattern());
    (void)coarse.take(product);
    const Eigen::MatrixXd P = dense(product.prolongation(), level_.halo(), product.coarse());
    const Eigen::MatrixXd A = dense(level_.matrix(), level_.halo(), level_.halo());
    Eigen::MatrixXd expected = P.transpose() * A * P;
    for (Eigen::Index k = 0; k < expected.rows(); ++k) {
      if (expected(k, k) == 0.0) expected(k, k) = 1.0;
    }
    const Eigen::MatrixXd actual = dense(coarse.matrix(), product.coarse(), product.coarse());
    EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 1e-6 * expected.cwiseAbs().maxCoeff());
    EXPECT_GT(P.rows(), 3 * P.cols() / 2);
  }
}

TEST_F(Coarsened, TheLargestEigenvalueIsNearlyThatOfTheDenseMatrix) {
  const Eigen::MatrixXd A = dense(level_.matrix(), level_.halo(), level_.halo());
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(A.rows(), A.cols());
  for (Eigen::Index k = 0; k < A.rows(); k += 3) D.block(k, k, 3, 3) = A.block(k, k, 3, 3);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> exact(A, D, Eigen::EigenvaluesOnly);
  const double largest = exact.eigenvalues().maxCoeff();
  EXPECT_LT(level_.largest_eigenvalue(), 1.001 * largest);
  EXPECT_GT(level_.largest_eigenvalue(), 0.95 * largest);
}

TEST_F(Coarsened, ProductsWithVectorsAreThoseOfPetsc) {
  Handle<Vec> x, y;
  check(MatCreateVecs(lattice_.K(), x.out(), y.out()));
  check(VecSetRandom(x.get(), nullptr));
  check(MatMult(lattice_.K(), x.get(), y.get()));
  Level::Work<float> work(level_.num_local_entries());
  const ConstArrayView values(x.get()), expected(y.get());
  std::ranges::transform(values.span(), work.x.begin(), [](double v) { return static_cast<float>(v); });
  level_.residual(work);
  for (std::size_t k = 0; k < level_.num_own_entries(); ++k) {
    EXPECT_NEAR(-work.r[k], expected[static_cast<PetscInt>(k)], 2e-5);
  }
}

}  // namespace
}  // namespace pliant
