// Rotations and rigid motions: the exponential, its inverse and its derivative, near zero, near half a turn, and after
// many products.
#include "time/bodies.hpp"
#include "time/lie_group.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace pliant::test_lie_group {
namespace {

using test::largest_difference;
using test::Random;
using test::random_configuration;
using test::random_coordinates;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double pi = std::numbers::pi;

template <int k>
long double stumpff_series(long double x) {
  long double term = 1.0L, sum = 0.0L;
  for (int i = 2; i <= k; ++i) term /= i;
  for (int j = 0; j < 60; ++j) {
    sum += term;
    term *= -x / ((k + 2 * j + 1) * (k + 2 * j + 2));
  }
  return sum;
}

template <int k>
void expect_stumpff(double x) {
  double scale = 1.0;  // c_k(0)
  for (int i = 2; i <= k; ++i) scale /= i;
  EXPECT_NEAR(stumpff<k>(x), static_cast<double>(stumpff_series<k>(x)), 4 * eps * scale)
      << "c_" << k << "(" << x << ")";
  // The slope is a sum of two of them.
  const double h = 1e-5 * (1.0 + x);
  const auto difference =
      static_cast<double>((stumpff_series<k>(x + h) - stumpff_series<k>(x - h)) / (2 * static_cast<long double>(h)));
  EXPECT_NEAR(stumpff<k>(Dual<double>(x, 1.0)).slope, difference, 1e-8 * scale) << "c_" << k << "'(" << x << ")";
}

TEST(Stumpff, HasItsDigitsFromZeroToAFullTurn) {
  for (const double x : {0.0, 1e-300, 1e-20, 1e-8, 0.01, 0.5, 1.0, 3.0, 9.8, 10.0, 10.1, 25.0, 39.0}) {
    [x]<int... k>(std::integer_sequence<int, k...>) {
      (expect_stumpff<k>(x), ...);
    }
    (std::make_integer_sequence<int, 8>{});
  }
}

template <class T>
class LieGroups : public testing::Test {};

struct NameOfGroup {
  template <class T>
  static std::string GetName(int) {
    return std::is_same_v<T, SO3> ? "SO3" : "SE3";
  }
};
using Groups = testing::Types<SO3, SE3>;
TYPED_TEST_SUITE(LieGroups, Groups, NameOfGroup);

/// ad(a) b, the bracket of the Lie algebra.
std::array<double, 3> bracket(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return cross(a, b);
}
std::array<double, 6> bracket(const std::array<double, 6>& a, const std::array<double, 6>& b) {
  const Vector3<double> a_w = {a[0], a[1], a[2]}, a_u = {a[3], a[4], a[5]};
  const Vector3<double> b_w = {b[0], b[1], b[2]}, b_u = {b[3], b[4], b[5]};
  const auto w = cross(a_w, b_w), u = cross(a_w, b_u) + cross(a_u, b_w);
  return {w[0], w[1], w[2], u[0], u[1], u[2]};
}

// dexp_{-xi} = sum_k (-ad xi)^k / (k + 1)!, summed as it stands.
TYPED_TEST(LieGroups, VelocityIsTheSeriesInTheBracket) {
  Random random(1);
  for (const double angle : {1e-9, 1e-4, 0.3, 2.0, 3.1, 3.3}) {
    const auto xi = random_coordinates<TypeParam>(random, angle), rate = random_coordinates<TypeParam>(random, 1.0);
    auto sum = rate, term = rate;
    for (int k = 1; k < 40; ++k) {
      term = bracket(xi, term);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += term[i] *= -1.0 / (k + 1);
    }
    // The terms of the series grow to some ten before they shrink.
    EXPECT_LT(largest_difference(TypeParam::velocity(xi, rate), sum), 100 * eps) << angle;
  }
}

// What a moving configuration becomes, seen from where it is, changes at the velocity.
TYPED_TEST(LieGroups, VelocityIsTheRateOfTheConfiguration) {
  Random random(2);
  constexpr double h = 1e-5;  // error of a central difference: h^2, and eps / h
  const auto a = random_configuration<TypeParam>(random);
  const auto xi = random_coordinates<TypeParam>(random, 2.5), rate = random_coordinates<TypeParam>(random, 1.0);
  const auto at = [&](double t) {
    auto moved = xi;
    for (std::size_t i = 0; i < xi.size(); ++i) moved[i] += t * rate[i];
    auto b = a;
    TypeParam::retract(a, moved, b);
    return b;
  };
  auto difference = TypeParam::difference(at(0.0), at(h));
  const auto backward = TypeParam::difference(at(0.0), at(-h));
  for (std::size_t i = 0; i < xi.size(); ++i) difference[i] = (difference[i] - backward[i]) / (2 * h);
  EXPECT_LT(largest_difference(TypeParam::velocity(xi, rate), difference), 1e-8);
}

TYPED_TEST(LieGroups, DifferenceInvertsRetractToRounding) {
  Random random(3);
  for (const double angle : {0.0, 1e-200, 1e-12, 1e-5, 0.1, 1.0, 3.0, pi - 1e-6, pi - 1e-12}) {
    const auto a = random_configuration<TypeParam>(random);
    auto xi = random_coordinates<TypeParam>(random, angle);
    auto b = a;
    TypeParam::retract(a, xi, b);
    const auto back = TypeParam::difference(a, b);
    // Orientations and places are rounded at size one, whatever the size of xi.
    EXPECT_LT(largest_difference(back, xi), 40 * eps) << angle;
  }
  // A quarter turn about x beyond half a turn is three quarters the other way round.
  const std::array<double, TypeParam::num_coordinates> beyond = {1.5 * pi};
  auto a = random_configuration<TypeParam>(random), b = a;
  TypeParam::retract(a, beyond, b);
  EXPECT_NEAR(TypeParam::difference(a, b)[0], -0.5 * pi, 20 * eps);
}

// From the unit, small coordinates keep all their digits.
TYPED_TEST(LieGroups, SmallCoordinatesKeepTheirDigits) {
  std::array<double, TypeParam::num_numbers> unit{}, b{};
  unit[TypeParam::num_numbers - 4] = 1.0;
  for (const double size : {1e-150, 1e-12, 1e-7, 1e-3}) {
    Random random(4);
    auto xi = random.numbers<TypeParam::num_coordinates>();
    for (double& x : xi) x *= size;
    TypeParam::retract(unit, xi, b);
    EXPECT_LT(largest_difference(TypeParam::difference(unit, b), xi), 20 * eps * size);
  }
}

// exp as the series of 4x4 matrices (p' = R x + p).
TEST(SE3Exponential, IsThatOfItsMatrix) {
  Random random(5);
  for (const double angle : {1e-6, 0.5, 2.0, 3.1, 5.0}) {
    const auto xi = random_coordinates<SE3>(random, angle);
    using Matrix = std::array<std::array<double, 4>, 4>;
    const Matrix A = {{{0, -xi[2], xi[1], xi[3]}, {xi[2], 0, -xi[0], xi[4]}, {-xi[1], xi[0], 0, xi[5]}, {0, 0, 0, 0}}};
    Matrix term{}, sum{};
    for (std::size_t i = 0; i < 4; ++i) term[i][i] = sum[i][i] = 1.0;
    for (int k = 1; k < 50; ++k) {
      Matrix next{};
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          for (std::size_t m = 0; m < 4; ++m) next[i][j] += term[i][m] * A[m][j] / k;
          sum[i][j] += next[i][j];
        }
      }
      term = next;
    }
    const std::array<double, 7> unit = {0, 0, 0, 1, 0, 0, 0};
    std::array<double, 7> b{};
    SE3::retract(unit, xi, b);
    const Tensor3<double> R = rotation_matrix(SE3::rotation(b));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(b[i], sum[i][3], 500 * eps);  // the terms of the series grow to some thirty
      for (std::size_t j = 0; j < 3; ++j)
        EXPECT_NEAR(R(static_cast<int>(i), static_cast<int>(j)), sum[i][j], 500 * eps);
    }
  }
}

TEST(Quaternions, TurnAndComposeAsMatrices) {
  Random random(6);
  const Quaternion a = test::unit(random.numbers<4>()), b = test::unit(random.numbers<4>());
  const auto x = random.numbers<3>();
  EXPECT_LT(largest_difference(turn(product(a, b), x), turn(a, turn(b, x))), 20 * eps);
  EXPECT_LT(largest_difference(turn(inverse(a), turn(a, x)), x), 20 * eps);
  const Vector3<double> xi = {0.4, -0.7, 0.2};
  EXPECT_LT(largest_difference(turn(exponential(xi), x), turn(xi, x)), 20 * eps);
  // A quarter turn about z takes x to y.
  EXPECT_LT(largest_difference(turn(exponential({0, 0, pi / 2}), {1, 0, 0}), {0, 1, 0}), 4 * eps);
}

// A product of 1e5 rotations is a rotation still, and turns that add up to many full ones end where they should.
TYPED_TEST(LieGroups, RotationsStayOrthogonalOver100000Steps) {
  Random random(7);
  auto a = random_configuration<TypeParam>(random), b = a;
  for (int n = 0; n < 100000; ++n) {
    TypeParam::retract(a, random_coordinates<TypeParam>(random, 0.5), b);
    std::swap(a, b);
  }
  EXPECT_LT(test::distance_from_orthogonal(TypeParam::rotation(a)), 1e-14);

  constexpr int num_turns = 1000, steps_per_turn = 100;
  auto start = a;
  for (int n = 0; n < num_turns * steps_per_turn; ++n) {
    std::array<double, TypeParam::num_coordinates> xi{};
    xi[0] = 2 * pi / steps_per_turn * 0.6, xi[1] = 2 * pi / steps_per_turn * 0.8;
    TypeParam::retract(a, xi, b);
    std::swap(a, b);
  }
  const auto xi = TypeParam::difference(start, a);
  // 1e5 roundings of one quaternion, and as many times that of xi: eps / 2 of 2 pi / 100 each.
  EXPECT_LT(std::hypot(xi[0], xi[1], xi[2]), 1e5 * eps);
}

// As vectors: every body by itself, on whatever rank.
TYPED_TEST(LieGroups, SpacesWorkBodyByBody) {
  constexpr std::size_t n = TypeParam::num_numbers, d = TypeParam::num_coordinates;
  const std::size_t num_bodies = test::num_bodies();
  const auto a = test::zeros(n * num_bodies), b = test::zeros(n * num_bodies);
  const auto xi = test::zeros(d * num_bodies), rate = test::zeros(d * num_bodies), v = test::zeros(d * num_bodies);
  Random random(8);
  for (std::size_t k = 0; k < num_bodies; ++k) {
    test::put(a.get(), k, random_configuration<TypeParam>(random));
    test::put(xi.get(), k, random_coordinates<TypeParam>(random, 2.0));
    test::put(rate.get(), k, random_coordinates<TypeParam>(random, 1.0));
  }
  const LieGroupSpace<TypeParam> space;
  space.retract(a.get(), xi.get(), b.get());
  space.velocity(xi.get(), rate.get(), v.get());
  for (std::size_t k = 0; k < num_bodies; ++k) {
    const auto a_k = test::numbers_of<n>(a.get(), k);
    const auto xi_k = test::numbers_of<d>(xi.get(), k);
    std::array<double, n> b_k{};
    TypeParam::retract(a_k, xi_k, b_k);
    EXPECT_EQ(test::numbers_of<n>(b.get(), k), b_k);
    EXPECT_EQ(test::numbers_of<d>(v.get(), k), TypeParam::velocity(xi_k, test::numbers_of<d>(rate.get(), k)));
  }
  space.difference(a.get(), b.get(), v.get());
  check(VecAXPY(v.get(), -1.0, xi.get()));
  PetscReal largest = 0.0;
  check(VecNorm(v.get(), NORM_INFINITY, &largest));
  EXPECT_LT(largest, 40 * eps);
}

}  // namespace
}  // namespace pliant::test_lie_group
