#include "fem/element.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_element {
namespace {

template <class Element>
class Elements : public ::testing::Test {};

using AllElements = ::testing::Types<Tet<1>, Tet<2>, Triangle<1>, Triangle<2>>;
TYPED_TEST_SUITE(Elements, AllElements);

/// The corners, then the middles of the edges.
template <class Element>
std::array<typename Element::Point, Element::num_nodes> nodes() {
  std::array<typename Element::Point, Element::num_nodes> x{};
  for (int a = 1; a < Element::num_corners; ++a) x[a][a - 1] = 1.0;
  for (int a = Element::num_corners; a < Element::num_nodes; ++a) {
    const auto [i, j] = Element::edge(a - Element::num_corners);
    for (int k = 0; k < Element::dim; ++k) x[a][k] = 0.5 * (x[i][k] + x[j][k]);
  }
  return x;
}

template <class Element>
typename Element::Point somewhere() {
  typename Element::Point xi;
  for (int k = 0; k < Element::dim; ++k) xi[k] = 0.13 + 0.11 * k;
  return xi;
}

TYPED_TEST(Elements, AreOneAtTheirNodeAndZeroAtTheOthers) {
  const auto x = nodes<TypeParam>();
  for (int b = 0; b < TypeParam::num_nodes; ++b) {
    const auto N = TypeParam::values(x[b]);
    for (int a = 0; a < TypeParam::num_nodes; ++a) EXPECT_EQ(N[a], a == b ? 1.0 : 0.0) << a << " at " << b;
  }
}

TYPED_TEST(Elements, SumToOneAndTheirGradientsToZero) {
  const auto xi = somewhere<TypeParam>();
  double sum = 0.0;
  for (const double n : TypeParam::values(xi)) sum += n;
  EXPECT_NEAR(sum, 1.0, 1e-15);
  for (int k = 0; k < TypeParam::dim; ++k) {
    double slope = 0.0;
    for (const auto& g : TypeParam::gradients(xi)) slope += g[k];
    EXPECT_NEAR(slope, 0.0, 1e-15);
  }
}

// The shape functions are at most quadratic: central differences are exact but for rounding.
TYPED_TEST(Elements, GradientsAreDifferencesOfValues) {
  const auto xi = somewhere<TypeParam>();
  const auto gradients = TypeParam::gradients(xi);
  const double h = 1.0 / 64.0;
  for (int k = 0; k < TypeParam::dim; ++k) {
    auto ahead = xi, behind = xi;
    ahead[k] += h;
    behind[k] -= h;
    const auto up = TypeParam::values(ahead), down = TypeParam::values(behind);
    for (int a = 0; a < TypeParam::num_nodes; ++a) EXPECT_NEAR(gradients[a][k], (up[a] - down[a]) / (2.0 * h), 1e-13);
  }
}

// Nodes depend on the coordinates they say, and on no others.
TYPED_TEST(Elements, DependOnOneOrTwoBarycentricCoordinates) {
  const auto g = TypeParam::barycentric_gradients(somewhere<TypeParam>());
  for (int a = 0; a < TypeParam::num_nodes; ++a) {
    for (int k = 0; k < TypeParam::num_corners; ++k) EXPECT_EQ(TypeParam::depends(a, k), g[a][k] != 0.0) << a << k;
  }
}

TYPED_TEST(Elements, InterpolatePolynomialsOfTheirDegree) {
  const auto polynomial = [](const auto& x) {
    double linear = 0.7, quadratic = 0.0;
    for (int k = 0; k < TypeParam::dim; ++k) {
      linear += (k + 1.5) * x[k];
      quadratic += (0.3 - k) * x[k] * x[(k + 1) % TypeParam::dim] + 0.4 * x[k] * x[k];
    }
    return TypeParam::order == 1 ? linear : linear + quadratic;
  };
  const auto xi = somewhere<TypeParam>();
  const auto x = nodes<TypeParam>();
  const auto N = TypeParam::values(xi);
  double value = 0.0;
  for (int a = 0; a < TypeParam::num_nodes; ++a) value += N[a] * polynomial(x[a]);
  EXPECT_NEAR(value, polynomial(xi), 1e-14);
}

}  // namespace
}  // namespace pliant::test_element
