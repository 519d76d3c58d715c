#include "base/simd.hpp"
#include "base/tensor.hpp"

#include <random>

#include <gtest/gtest.h>

namespace pliant::test_tensor {
namespace {

Tensor3<double> random_tensor(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return make_tensor([&](int, int) { return uniform(engine); });
}

void expect_equal(const Tensor3<double>& A, const Tensor3<double>& B) {
  for (std::size_t n = 0; n < 9; ++n) EXPECT_NEAR(A.a[n], B.a[n], 1e-15);  // entries of order 1
}

const Tensor3<double> A = random_tensor(1);
const Tensor3<double> B = random_tensor(2);

TEST(Tensor, IsRowMajor) {
  const Tensor3<double> C{{0, 1, 2, 3, 4, 5, 6, 7, 8}};
  EXPECT_EQ(C(1, 2), 5);
  EXPECT_EQ(transpose(C)(1, 2), 7);
  EXPECT_EQ(trace(C), 12);
}

TEST(Tensor, SumsAndMultiples) {
  expect_equal(A + B - B, A);
  expect_equal(2.0 * A, A + A);
  expect_equal(add_to_diagonal(A, 2.0), A + 2.0 * identity<double>());
}

TEST(Tensor, ProductsAgree) {
  EXPECT_NEAR(dot(A, B), trace(matmul(transpose(A), B)), 1e-15);
  expect_equal(transpose(matmul(A, B)), matmul(transpose(B), transpose(A)));
  expect_equal(matmul(A, identity<double>()), A);
}

TEST(Tensor, Invariants) {
  EXPECT_NEAR(det(matmul(A, B)), det(A) * det(B), 1e-15);
  EXPECT_NEAR(second_invariant(A), 0.5 * (trace(A) * trace(A) - trace(matmul(A, A))), 1e-15);
  EXPECT_GT(std::abs(det(A)), 1e-3);
}

TEST(Tensor, CofactorIsTheTransposedAdjugate) {
  expect_equal(matmul(transpose(cofactor(A)), A), det(A) * identity<double>());
}

TEST(Tensor, WorksOnPacks) {
  const Tensor3<Pack> P = make_tensor([](int i, int j) { return Pack(A(i, j)); });
  const Tensor3<Pack> C = cofactor(2.0 * P);
  const Tensor3<double> expected = cofactor(2.0 * A);
  for (std::size_t n = 0; n < 9; ++n) EXPECT_NEAR(C.a[n][pack_size - 1], expected.a[n], 1e-15);
}

}  // namespace
}  // namespace pliant::test_tensor
