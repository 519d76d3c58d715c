#include "material/projection.hpp"
#include "states.hpp"

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
  project_to_positive_semidefinite(projected);
  EXPECT_GE(least_quotient(projected), 0.0);
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) EXPECT_NEAR(projected[9 * p + q], projected[9 * q + p], 1e-10 * E);
  }
  // A projection: a second time changes nothing but rounding.
  Tangent<double> twice = projected;
  project_to_positive_semidefinite(twice);
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
  project_to_positive_semidefinite(projected);
  EXPECT_EQ(projected, A);
}

TYPED_TEST(Projection, ClampsAtTheFloor) {
  Tangent<double> A = stiffness_tensor(law_of<TypeParam>(E, 0.3), compressed);
  const double floor = 0.1 * E;
  project_to_positive_semidefinite(A, floor);
  EXPECT_GE(least_quotient(A), floor * (1 - 1e-12));
}

TYPED_TEST(Projection, TreatsEachLaneAlone) {
  const auto law = law_of<TypeParam>(E, 0.3);
  const auto state = [](std::size_t lane) { return lane % 2 == 0 ? compressed : moderate_state(7); };
  Tensor3<Pack> H;
  for (std::size_t n = 0; n < 9; ++n) H.a[n] = Pack([&](auto lane) { return state(lane).a[n]; });
  Tangent<Pack> A = tangent(law, H);
  project_to_positive_semidefinite(A);
  for (std::size_t lane = 0; lane < Pack::size(); ++lane) {
    Tangent<double> expected = tangent(law, state(lane));
    project_to_positive_semidefinite(expected);
    for (std::size_t n = 0; n < 81; ++n) EXPECT_NEAR(A[n][lane], expected[n], 1e-12 * E);
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
  project_to_positive_semidefinite(A);
  EXPECT_TRUE(std::isnan(A[0]));
}

}  // namespace
}  // namespace pliant::test_projection
