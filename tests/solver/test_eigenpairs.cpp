#include "base/error.hpp"
#include "petsc/handle.hpp"
#include "solver/eigenpairs.hpp"
#include "solver/merit.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using Entry = std::function<double(PetscInt, PetscInt)>;

/// A banded matrix of n rows over all ranks; `entry` gives rows and columns up to `width` apart.
Handle<Mat> banded(PetscInt n, PetscInt width, const Entry& entry) {
  Handle<Mat> A;
  check(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, n, n, 2 * static_cast<int>(width) + 1, nullptr,
                     2 * static_cast<int>(width) + 1, nullptr, A.out()));
  PetscInt first = 0, last = 0;
  check(MatGetOwnershipRange(A.get(), &first, &last));
  for (PetscInt i = first; i < last; ++i) {
    for (PetscInt j = std::max<PetscInt>(0, i - width); j <= std::min(n - 1, i + width); ++j) {
      check(MatSetValue(A.get(), i, j, entry(i, j), INSERT_VALUES));
    }
  }
  check(MatAssemblyBegin(A.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(A.get(), MAT_FINAL_ASSEMBLY));
  check(MatSetOption(A.get(), MAT_SYMMETRIC, PETSC_TRUE));
  return A;
}

/// A chain of n unit masses and springs with its ends held, and a spring of stiffness c from each mass to the ground.
Handle<Mat> chain(PetscInt n, double c = 0.0) {
  return banded(n, 1, [=](PetscInt i, PetscInt j) { return i == j ? 2.0 + c : -1.0; });
}

Handle<Mat> diagonal(PetscInt n, const std::function<double(PetscInt)>& entry) {
  return banded(n, 0, [&](PetscInt i, PetscInt) { return entry(i); });
}

/// The k-th eigenvalue of the chain, from 1.
double of_chain(PetscInt n, int k) {
  return 4.0 * std::pow(std::sin(0.5 * k * std::numbers::pi / (n + 1)), 2);
}

/// K x = lambda M x and x . M x = 1, up to rounding.
void expect_pairs(const EigenProblem& problem, const Eigenpairs& found) {
  for (std::size_t i = 0; i < found.values.size(); ++i) {
    Handle<Vec> Kx, Mx;
    check(MatCreateVecs(problem.K, Kx.out(), Mx.out()));
    check(MatMult(problem.K, found.vectors[i].get(), Kx.get()));
    check(MatMult(problem.M, found.vectors[i].get(), Mx.get()));
    EXPECT_NEAR(dot(found.vectors[i].get(), Mx.get()), 1.0, 1e-10);
    check(VecAXPY(Kx.get(), -found.values[i], Mx.get()));
    EXPECT_LE(norm(Kx.get()), 1e-8);
  }
}

TEST(Eigenpairs, AreThoseOfAChain) {
  constexpr PetscInt n = 200;
  const Handle<Mat> K = chain(n), M = diagonal(n, [](PetscInt) { return 2.0; });
  const EigenProblem problem{K.get(), M.get()};
  const Eigenpairs found = smallest_eigenpairs(problem, 6);
  ASSERT_EQ(found.values.size(), 6U);
  for (int k = 1; k <= 6; ++k) EXPECT_NEAR(found.values[static_cast<std::size_t>(k - 1)], of_chain(n, k) / 2.0, 1e-12);
  expect_pairs(problem, found);
}

TEST(Eigenpairs, BeginWithTheMostNegativeOne) {
  constexpr PetscInt n = 200;
  const Handle<Mat> K = chain(n, -0.5), M = diagonal(n, [](PetscInt) { return 1.0; });
  const EigenProblem problem{K.get(), M.get()};
  const Eigenpairs found = smallest_eigenpairs(problem, 4);
  for (int k = 1; k <= 4; ++k) EXPECT_NEAR(found.values[static_cast<std::size_t>(k - 1)], of_chain(n, k) - 0.5, 1e-10);
  expect_pairs(problem, found);
}

TEST(Eigenpairs, AreZeroWhereNothingHolds) {
  constexpr PetscInt n = 100;
  const Handle<Mat> K = banded(n, 1,
                               [=](PetscInt i, PetscInt j) {
                                 return i != j ? -1.0 : i == 0 || i == n - 1 ? 1.0 : 2.0;
                               }),
                    M = diagonal(n, [](PetscInt) { return 1.0; });
  const Eigenpairs found = smallest_eigenpairs({K.get(), M.get()}, 2);
  EXPECT_LE(std::abs(found.values[0]), found.roundings[0]);
  EXPECT_GT(found.values[1], 1e4 * found.roundings[1]);
}

// What is light and stiff does not hide that something heavy moves slowly.
TEST(Eigenpairs, AreNotZeroBesideFastOnes) {
  constexpr PetscInt n = 20;
  constexpr double stiff = 1e8, soft = 0.5;
  const Handle<Mat> K = banded(n, 1,
                               [=](PetscInt i, PetscInt j) {
                                 if (i != j) return -stiff;
                                 return i == 0 ? stiff + soft : i == n - 1 ? stiff : 2.0 * stiff;
                               }),
                    M = diagonal(n, [](PetscInt i) { return i == n - 1 ? 1.0 : 1e-10; });
  const Eigenpairs found = smallest_eigenpairs({K.get(), M.get()}, 1);
  EXPECT_NEAR(found.values[0], soft, 1e-5);
  EXPECT_GT(found.values[0], 1e2 * found.roundings[0]);
}

// Two equal chains: every eigenvalue twice.
TEST(Eigenpairs, MayBeEqual) {
  constexpr PetscInt n = 60;
  const Handle<Mat> K = banded(2 * n, 2,
                               [](PetscInt i, PetscInt j) {
                                 const PetscInt apart = std::abs(i - j);
                                 return apart == 0 ? 2.0 : apart == 2 ? -1.0 : 0.0;
                               }),
                    M = diagonal(2 * n, [](PetscInt) { return 1.0; });
  const EigenProblem problem{K.get(), M.get()};
  const Eigenpairs found = smallest_eigenpairs(problem, 4);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(found.values[i], of_chain(n, 1 + static_cast<int>(i) / 2), 1e-12);
  }
  expect_pairs(problem, found);
}

// Every third unknown is the multiplier of (x_i + x_{i+1} = 0): what is left are modes with both masses opposed.
TEST(Eigenpairs, OfASaddlePointAreThoseOfItsMotions) {
  constexpr PetscInt n = 30;
  const auto is_multiplier = [](PetscInt i) { return i % 3 == 2; };
  const Handle<Mat> K = banded(n, 2,
                               [&](PetscInt i, PetscInt j) {
                                 if (i / 3 != j / 3) return 0.0;
                                 if (i == j) return is_multiplier(i) ? 0.0 : 1.0 + static_cast<double>(i / 3);
                                 return is_multiplier(i) || is_multiplier(j) ? 1.0 : 0.0;
                               }),
                    M = diagonal(n, [&](PetscInt i) { return is_multiplier(i) ? 0.0 : 1.0; });
  const EigenProblem problem{K.get(), M.get(), n / 3};
  const Eigenpairs found = smallest_eigenpairs(problem, 5);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(found.values[i], 1.0 + static_cast<double>(i), 1e-10);
}

TEST(Eigenpairs, NearestOnesSurroundTheTarget) {
  constexpr PetscInt n = 200;
  const Handle<Mat> K = chain(n), M = diagonal(n, [](PetscInt) { return 1.0; });
  const Eigenpairs found = nearest_eigenpairs({K.get(), M.get()}, 2, 0.5 * (of_chain(n, 50) + of_chain(n, 51)));
  EXPECT_NEAR(found.values[0], of_chain(n, 50), 1e-12);
  EXPECT_NEAR(found.values[1], of_chain(n, 51), 1e-12);
}

TEST(Eigenpairs, AreNoMoreThanTheMasses) {
  constexpr PetscInt n = 50;
  const Handle<Mat> K = chain(n), M = diagonal(n, [](PetscInt i) { return i == 10 || i == 30 ? 1.0 : 0.0; });
  const EigenProblem problem{K.get(), M.get()};
  const Eigenpairs found = smallest_eigenpairs(problem, 10);
  EXPECT_EQ(found.values.size(), 2U);
  expect_pairs(problem, found);
  const Handle<Mat> none = diagonal(n, [](PetscInt) { return 0.0; });
  EXPECT_THROW(smallest_eigenpairs({K.get(), none.get()}, 1), SolveError);
}

// A part without mass that nothing holds.
TEST(Eigenpairs, DoNotExistWhereTheStiffnessIsSingular) {
  constexpr PetscInt n = 20;
  const auto is_loose = [](PetscInt i) { return i == 5; };
  const Handle<Mat> K = diagonal(n, [&](PetscInt i) { return is_loose(i) ? 0.0 : 1.0; }),
                    M = diagonal(n, [&](PetscInt i) { return is_loose(i) ? 0.0 : 1.0; });
  EXPECT_THROW(smallest_eigenpairs({K.get(), M.get()}, 1), SolveError);
}

}  // namespace
}  // namespace pliant
