#include "material/projection.hpp"
#include "states.hpp"

#include <eigen3/Eigen/Eigenvalues>

#include <gtest/gtest.h>

namespace pliant::test_projection {
namespace {

using namespace testing_states;

constexpr double E = 1e6;  // [Pa]

/// x . A x.
double quadratic_form(const Tangent<double>& A, const Matrix& x) {
  double value = 0;
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) value += x.a[p] * A[9 * p + q] * x.a[q];
  }
  return value;
}

/// The least x . A x / x . x over many directions.
double least_quotient(const Tangent<double>& A) {
  double least = std::numeric_limits<double>::infinity();
  for (unsigned seed = 0; seed < 5000; ++seed) {
    const Matrix x = random_matrix(seed, 1.0);
    least = std::min(least, quadratic_form(A, x) / norm_squared(x));
  }
  return least;
}

/// The projection in all lanes at once; the first one. The displacement gradient only decides how quick it is.
void project(Tangent<double>& A, const Matrix& H, double floor = 0.0) {
  Tangent<Pack> packed;
  std::ranges::transform(A, packed.begin(), [](double a) { return Pack(a); });
  Tensor3<Pack> packed_H;
  std::ranges::transform(H.a, packed_H.a.begin(), [](double h) { return Pack(h); });
  project_to_positive_semidefinite(packed, packed_H, floor);
  std::ranges::transform(packed, A.begin(), [](const Pack& a) { return static_cast<double>(a[0]); });
}

/// The same by another solver.
Tangent<double> projected_by_eigen(Tangent<double> A, double floor) {
  Eigen::Map<Eigen::Matrix<double, 9, 9>> M(A.data());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(M);
  const Eigen::Matrix<double, 9, 1> raised = solver.eigenvalues().cwiseMax(floor);
  M = solver.eigenvectors() * raised.asDiagonal() * solver.eigenvectors().transpose();
  return A;
}

/// Strong compression along x: the tangent is indefinite (the body would rather buckle).
const Matrix compressed{{-0.4, 0.05, 0, 0.02, 0.1, 0, 0, 0, 0.1}};

template <class L>
class Projection : public testing::Test {};
using Laws = testing::Types<SaintVenantKirchhoff<double>, NeoHookean<double>>;
TYPED_TEST_SUITE(Projection, Laws);

TYPED_TEST(Projection, MakesTheIndefiniteSemidefinite) {
  const Tangent<double> A = stiffness_tensor(law_of<TypeParam>(E, 0.3), compressed);
  ASSERT_LT(least_quotient(A), -1e-3 * E);
  Tangent<double> projected = A;
  project(projected, compressed);
  EXPECT_GE(least_quotient(projected), -1e-15 * E);
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) EXPECT_NEAR(projected[9 * p + q], projected[9 * q + p], 1e-10 * E);
  }
  // A projection: a second time changes nothing but rounding.
  Tangent<double> twice = projected;
  project(twice, compressed);
  for (std::size_t n = 0; n < 81; ++n) EXPECT_NEAR(twice[n], projected[n], 1e-12 * E);
  // The positive directions are untouched: the change is itself negative only where A was.
  double removed = 0, kept = 0;
  for (std::size_t n = 0; n < 81; ++n) {
    removed += (projected[n] - A[n]) * projected[n];
    kept += projected[n] * projected[n];
  }
  EXPECT_NEAR(removed, 0.0, 1e-12 * kept);
}

TYPED_TEST(Projection, LeavesTheDefiniteAlone) {
  const Matrix stretched{{0.2, 0, 0, 0, 0.2, 0, 0, 0, 0.2}};
  const Tangent<double> A = stiffness_tensor(law_of<TypeParam>(E, 0.3), stretched);
  Tangent<double> projected = A;
  project(projected, stretched);
  EXPECT_EQ(projected, A);
}

TYPED_TEST(Projection, ClampsAtTheFloor) {
  Tangent<double> A = stiffness_tensor(law_of<TypeParam>(E, 0.3), compressed);
  const double floor = 0.1 * E;
  project(A, compressed, floor);
  EXPECT_GE(least_quotient(A), floor * (1 - 1e-12));
}

TYPED_TEST(Projection, TreatsEachLaneAlone) {
  const auto law = law_of<TypeParam>(E, 0.3);
  const auto state = [](std::size_t lane) { return lane % 2 == 0 ? compressed : moderate_state(7); };
  Tensor3<Pack> H;
  for (std::size_t n = 0; n < 9; ++n) H.a[n] = Pack([&](auto lane) { return state(lane).a[n]; });
  Tangent<Pack> A = tangent(law, H);
  project_to_positive_semidefinite(A, H);
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    Tangent<double> expected = tangent(law, state(lane));
    project(expected, state(lane));
    for (std::size_t n = 0; n < 81; ++n) EXPECT_NEAR(A[n][lane], expected[n], 1e-12 * E);
  }
}

// Isotropic laws near rest, with eigenvalues around zero, and far from it; a law with fibres; any symmetric matrix; and
// frames that have nothing to do with the matrix, flattened ones included.
TEST(ProjectionOfAnyMatrix, IsThatOfAnotherSolver) {
  const auto compare = [](const Tangent<double>& A, const Matrix& H, double floor) {
    double size = 0.0;
    for (const double a : A) size = std::max(size, std::abs(a));
    Tangent<double> projected = A;
    project(projected, H, floor);
    const Tangent<double> expected = projected_by_eigen(A, floor);
    for (std::size_t n = 0; n < 81; ++n) EXPECT_NEAR(projected[n], expected[n], 1e-13 * size);
  };
  const Matrix flat{{-1, 0, 0, 0, -1, 0, 0, 0, 0.5}}, none{};
  for (unsigned seed = 0; seed < 50; ++seed) {
    Tangent<double> A;
    for (std::size_t k = 0; k < 9; ++k) {
      const Matrix row = random_matrix(100 * seed + static_cast<unsigned>(k), 1.0);
      std::ranges::copy(row.a, A.begin() + static_cast<std::ptrdiff_t>(9 * k));
    }
    for (std::size_t p = 0; p < 9; ++p) {
      for (std::size_t q = 0; q < p; ++q) A[9 * p + q] = A[9 * q + p];
    }
    for (const Matrix& H : {none, flat, random_matrix(seed, 0.3)}) {
      for (const double floor : {0.0, 0.4}) compare(A, H, floor);
    }
    for (const double size : {1e-9, 1e-3, 0.2}) {
      const Matrix H = random_matrix(seed, size);
      compare(stiffness_tensor(law_of<NeoHookean<double>>(E, 0.3), H), H, 0.0);
    }
  }
}

TEST(ProjectionOfStresses, KeepsTensionAndDropsCompressionLaneByLane) {
  const Matrix Q = rotation(0.4, -1.0, 0.3);
  const auto turned = [&](double a, double b, double c) {
    return matmul(Q, matmul(Matrix{{a, 0, 0, 0, b, 0, 0, 0, c}}, transpose(Q)));
  };
  Tensor3<Pack> S;
  const auto stress = [&](std::size_t lane) { return lane % 2 == 0 ? turned(-3, 2, -1) : turned(1, 2, 3); };
  for (std::size_t n = 0; n < 9; ++n) S.a[n] = Pack([&](auto lane) { return stress(lane).a[n]; });
  project_to_positive_semidefinite(S);
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    const Matrix expected = lane % 2 == 0 ? turned(0, 2, 0) : turned(1, 2, 3);
    for (std::size_t n = 0; n < 9; ++n) EXPECT_NEAR(S.a[n][lane], expected.a[n], 1e-14);
  }
}

TEST(ProjectionOfInvertedCells, LeavesTheUndefinedAlone) {
  const Matrix inverted{{-2.5, 0, 0, 0, 0, 0, 0, 0, 0}};
  Tangent<double> A = stiffness_tensor(law_of<NeoHookean<double>>(E, 0.3), inverted);
  const double before = A[80];
  project(A, inverted);
  EXPECT_TRUE(std::isnan(A[0]));
  EXPECT_TRUE(A[80] == before || std::isnan(before));
}

}  // namespace
}  // namespace pliant::test_projection
