// Principal stretches and directions, also where they are equal, vanish or turn over.
#include "material/spectral.hpp"
#include "states.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_spectral {
namespace {

using namespace testing_states;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

Matrix diagonal(double a, double b, double c) {
  return {{a, 0, 0, 0, b, 0, 0, 0, c}};
}

/// A = V diag V^T with V^T V = I and the values in descending order.
void expect_decomposition(const Matrix& A) {
  const auto [values, V] = eigen_decomposition(A);
  const Matrix again = matmul(matmul(V, diagonal(values[0], values[1], values[2])), transpose(V));
  EXPECT_LE(norm(again - A), 8 * epsilon * norm(A));
  EXPECT_LE(norm(add_to_diagonal(matmul(transpose(V), V), -1.0)), 8 * epsilon);
  EXPECT_GE(values[0], values[1]);
  EXPECT_GE(values[1], values[2]);
}

TEST(EigenDecomposition, OfAnySymmetricTensor) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Matrix A = small_strain(random_matrix(seed, 1.0));
    expect_decomposition(A);
    expect_decomposition(1e-9 * A);
    expect_decomposition(1e9 * A);
    const Matrix Q = rotation(0.1 * seed, 1.0, -0.2);
    const auto turned = [&](const Matrix& D) { return small_strain(matmul(matmul(Q, D), transpose(Q))); };
    expect_decomposition(turned(diagonal(2, 2, 1)));  // twice the same
    expect_decomposition(turned(diagonal(-1, 2, -1)));
    expect_decomposition(turned(diagonal(1, 1 + 1e-9, 1 - 1e-9)));
    expect_decomposition(turned(diagonal(1e6, 1, 1e-6)));
  }
  expect_decomposition(Matrix{});
  expect_decomposition(identity<double>());
}

TEST(EigenDecomposition, OfAPackLaneByLane) {
  Tensor3<Pack> A;
  const auto of_lane = [](auto lane) { return small_strain(random_matrix(static_cast<unsigned>(lane), 1.0)); };
  for (std::size_t n = 0; n < 9; ++n) {
    A.a[n] = Pack([&](auto lane) { return of_lane(lane).a[n]; });
  }
  const auto packed = eigen_decomposition(A);
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    const auto alone = eigen_decomposition(of_lane(lane));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(static_cast<double>(packed.values[i][lane]), alone.values[i], 8 * epsilon);
    }
  }
}

/// F = sum l_i r_i n_i^T in right-handed frames, l_1 >= l_2 >= |l_3|, l_3 of the sign of J.
void expect_frames(const Matrix& F) {
  const auto at = principal_stretches(add_to_diagonal(F, -1.0));
  const double size = 1.0 + norm(F);
  EXPECT_LE(norm(at.assemble(at.l) - F), 16 * epsilon * size);
  for (const Matrix& frame : {at.n, at.r}) {
    EXPECT_LE(norm(add_to_diagonal(matmul(transpose(frame), frame), -1.0)), 1e-13);
    EXPECT_NEAR(det(frame), 1.0, 1e-13);
  }
  EXPECT_GE(at.l[0], at.l[1] - 16 * epsilon * size);
  EXPECT_GE(at.l[1], std::abs(at.l[2]) - 16 * epsilon * size);
  if (std::abs(det(F)) > 1e-12) {
    EXPECT_EQ(std::signbit(at.l[2]), std::signbit(det(F)));
  }
}

TEST(PrincipalStretches, OfAnyBody) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Matrix Q = rotation(0.3, 0.02 * seed, 1.0), R = rotation(-1.0, 0.5, 0.01 * seed);
    expect_frames(random_matrix(seed, 1.5));  // half of them inverted
    expect_frames(add_to_diagonal(random_matrix(seed, 1e-9), 1.0));
    for (const Matrix& D : {diagonal(2, 1, 0.5), diagonal(1, 1, 1), diagonal(2, 2, -0.5), diagonal(1, 1, 0),
                            diagonal(2, 0, 0), diagonal(3, 1, 1e-9), diagonal(0, 0, 0), diagonal(1, 0.5, -0.5)}) {
      expect_frames(matmul(matmul(Q, D), transpose(R)));
      expect_frames(D);
    }
  }
}

TEST(PrincipalStretches, KeepTheDigitsOfSmallStrains) {
  for (const double strain : {1e-12, 1e-8, 1e-4, 0.2}) {
    for (unsigned seed = 0; seed < 50; ++seed) {
      const Matrix H = random_matrix(seed, strain);
      auto expected = stretches_reference(converted<Quad>(H));
      std::sort(expected.begin(), expected.end(), std::greater<>{});
      const auto at = principal_stretches(H);
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(at.strain[i], static_cast<double>(expected[i] - 1), 8 * epsilon * norm(H));
      }
    }
  }
}

}  // namespace
}  // namespace pliant::test_spectral
