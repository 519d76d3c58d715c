// What every law must satisfy, run over the registry's list.
#include "material/registry.hpp"
#include "states.hpp"

#include <gtest/gtest.h>

namespace pliant {
namespace {

using namespace testing_states;

template <class L>
class EveryLaw : public testing::Test {
 protected:
  static constexpr unsigned num_states = 20;
  const L law = law_of<L>(3.0, 0.4);
};
TYPED_TEST_SUITE(EveryLaw, AlternativesOf<ElasticLawVariant>::type, NameOfLaw);

/// (f(H + h e_p) - f(H - h e_p)) / 2h in Quad: the error, h^2 and 1e-34 / h, is below 1e-19.
template <class F>
auto central_difference(const F& f, const Tensor3<Quad>& H, std::size_t p) {
  const Quad h = 1e-10;
  Tensor3<Quad> right = H, left = H;
  right.a[p] += h;
  left.a[p] -= h;
  return Quad(1 / (2 * h)) * (f(right) - f(left));
}

/// The tangent column by column, from dP of the nine unit increments.
template <class L>
Tangent<double> tangent_by_columns(const L& law, const Matrix& H) {
  const auto linearization = law.linearize(H);
  Tangent<double> A{};
  for (std::size_t q = 0; q < 9; ++q) {
    Matrix dH{};
    dH.a[q] = 1.0;
    const Matrix dP = linearization(dH);
    for (std::size_t p = 0; p < 9; ++p) A[9 * p + q] = dP.a[p];
  }
  return A;
}

TYPED_TEST(EveryLaw, EnergyIsTheTextbooks) {
  for (unsigned seed = 0; seed < this->num_states; ++seed) {
    const Matrix H = moderate_state(seed);
    const Quad expected = textbook_psi(this->law, converted<Quad>(H));
    ASSERT_GT(expected, 1e-3);
    EXPECT_LE(relative_difference(this->law.psi(H), expected), 1e-14);
  }
}

TYPED_TEST(EveryLaw, StressIsTheGradientOfTheEnergy) {
  for (unsigned seed = 0; seed < this->num_states; ++seed) {
    const Matrix H = moderate_state(seed);
    Tensor3<Quad> expected;
    for (std::size_t p = 0; p < 9; ++p) {
      expected.a[p] =
          central_difference([&](const auto& X) { return textbook_psi(this->law, X); }, converted<Quad>(H), p);
    }
    ASSERT_GT(norm(expected), 1e-2);
    EXPECT_LE(relative_difference(this->law.P(H), expected), 1e-14);
    EXPECT_LE(relative_difference(this->law.linearize(H).P, expected), 1e-14);
  }
}

TYPED_TEST(EveryLaw, TangentIsTheGradientOfTheStress) {
  for (unsigned seed = 0; seed < this->num_states; ++seed) {
    const Matrix H = moderate_state(seed);
    const Tangent<double> A = tangent(this->law, H);
    const Tangent<double> columns = tangent_by_columns(this->law, H);
    double size = 0;
    for (const double a : A) size = std::max(size, std::abs(a));
    ASSERT_GT(size, 1.0);
    for (std::size_t q = 0; q < 9; ++q) {
      const Tensor3<Quad> expected =
          central_difference([&](const auto& X) { return textbook_P(this->law, X); }, converted<Quad>(H), q);
      for (std::size_t p = 0; p < 9; ++p) {
        EXPECT_NEAR(A[9 * p + q], static_cast<double>(expected.a[p]), 1e-14 * size);
        EXPECT_NEAR(columns[9 * p + q], static_cast<double>(expected.a[p]), 1e-14 * size);
        EXPECT_EQ(A[9 * p + q], A[9 * q + p]);
      }
    }
  }
}

TYPED_TEST(EveryLaw, AtRestIsHookesLaw) {
  const double mu = this->law.mu, lambda = this->law.lambda;
  const Matrix zero{};
  EXPECT_EQ(this->law.psi(zero), 0.0);
  EXPECT_EQ(norm(this->law.P(zero)), 0.0);
  const Tangent<double> A = tangent(this->law, zero);
  const auto delta = [](std::size_t i, std::size_t j) { return i == j ? 1.0 : 0.0; };
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) {
      const std::size_t i = p / 3, J = p % 3, k = q / 3, L = q % 3;
      const double expected =
          mu * (delta(i, k) * delta(J, L) + delta(i, L) * delta(J, k)) + lambda * delta(i, J) * delta(k, L);
      EXPECT_NEAR(A[9 * p + q], expected, 1e-15 * lambda);
    }
  }
}

TYPED_TEST(EveryLaw, RotationNeitherStressesNorChangesTheEnergy) {
  const Matrix Q = rotation(0.7, -1.9, 1.1);
  const Matrix rigid = add_to_diagonal(Q, -1.0);
  if constexpr (TypeParam::constant_tangent) {
    EXPECT_GT(norm(this->law.P(rigid)), 0.1);  // a law linear in H cannot know a rotation
  } else {
    // The strain of a rounded rotation is of the order of 1e-16.
    EXPECT_LE(norm(this->law.P(rigid)), 1e-14 * this->law.lambda);
    EXPECT_LE(std::abs(this->law.psi(rigid)), 1e-30 * this->law.lambda);
    for (unsigned seed = 0; seed < this->num_states; ++seed) {
      const Matrix H = moderate_state(seed);
      EXPECT_LE(relative_difference(this->law.psi(rotated(Q, H)), this->law.psi(H)), 1e-14);
      EXPECT_LE(relative_difference(this->law.P(rotated(Q, H)), matmul(Q, this->law.P(H))), 1e-13);
    }
  }
}

TYPED_TEST(EveryLaw, PackEqualsScalarLaneByLane) {
  Tensor3<Pack> H, dH;
  for (std::size_t n = 0; n < 9; ++n) {
    H.a[n] = Pack([&](auto lane) { return moderate_state(lane).a[n]; });
    dH.a[n] = Pack([&](auto lane) { return moderate_state(lane + 100).a[n]; });
  }
  const Pack psi = this->law.psi(H);
  const Tensor3<Pack> P = this->law.P(H);
  const Tensor3<Pack> dP = this->law.linearize(H)(dH);
  const Tangent<Pack> A = tangent(this->law, H);
  for (unsigned lane = 0; lane < Pack::size(); ++lane) {
    const Matrix h = moderate_state(lane);
    // Not bit by bit: the compiler may fuse other multiplications and additions.
    EXPECT_LE(relative_difference(psi[lane], this->law.psi(h)), 1e-14);
    EXPECT_LE(relative_difference(make_tensor([&](int i, int j) -> double { return P(i, j)[lane]; }), this->law.P(h)),
              1e-14);
    EXPECT_LE(relative_difference(make_tensor([&](int i, int j) -> double { return dP(i, j)[lane]; }),
                                  this->law.linearize(h)(moderate_state(lane + 100))),
              1e-14);
    const Tangent<double> a = tangent(this->law, h);
    for (std::size_t n = 0; n < 81; ++n) EXPECT_NEAR(A[n][lane], a[n], 1e-13 * this->law.lambda);
  }
}

TYPED_TEST(EveryLaw, IncrementIsTheTangentTimesTheIncrement) {
  const Matrix H = moderate_state(3), dH = random_matrix(4, 1.0);
  const Matrix dP = this->law.linearize(H)(dH);
  const Tangent<double> A = tangent(this->law, H);
  Matrix expected{};
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) expected.a[p] += A[9 * p + q] * dH.a[q];
  }
  ASSERT_GT(norm(expected), 0.1);
  EXPECT_LE(relative_difference(dP, expected), 1e-14);
}

}  // namespace
}  // namespace pliant
