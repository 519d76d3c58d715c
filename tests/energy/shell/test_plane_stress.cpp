// Laws in plane stress: no stress across the layer, the least energy, digits, closed forms, derivatives.
#include "base/vector3.hpp"
#include "energy/shell/plane_stress.hpp"
#include "energy/solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_plane_stress {
namespace {

using Columns = std::array<std::array<double, 3>, 2>;

LayerAxes axes() {
  const Vector3<double> t1 = unit(Vector3<double>{1.0, 2.0, -0.5}), N = unit(cross(t1, Vector3<double>{0.3, 1.0, 0.4}));
  const std::array rows{t1, cross(N, t1), N};
  return make_tensor(
      [&](int a, int i) -> Pack { return rows[static_cast<std::size_t>(a)][static_cast<std::size_t>(i)]; });
}

/// h_a of a deformation of this size.
LayerColumns columns(double size) {
  const Columns rough{{{0.4 * size, -0.2 * size, 0.1 * size}, {0.3 * size, 0.5 * size, -0.4 * size}}};
  LayerColumns h;
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t i = 0; i < 3; ++i) h[a][i] = rough[a][i];
  }
  return h;
}

/// h_a = (l_a - 1) t_a.
LayerColumns stretches(double first, double second) {
  const LayerAxes e = axes();
  LayerColumns h;
  for (int i = 0; i < 3; ++i) {
    h[0][i] = (first - 1.0) * e(0, i);
    h[1][i] = (second - 1.0) * e(1, i);
  }
  return h;
}

double along(const LayerColumns& P, int a) {
  double sum = 0.0;
  const LayerAxes e = axes();
  for (int i = 0; i < 3; ++i) sum += P[a][i][0] * e(a, i)[0];
  return sum;
}

/// Fibres of some laws resist tension alone: at rest their stiffness jumps.
bool is_smooth_at_rest(const ElasticLawSpec& law) {
  return law.info().name != "holzapfel-gasser-ogden" && law.info().name != "holzapfel-ogden";
}

class Laws : public ::testing::TestWithParam<ElasticLawSpec> {
 protected:
  PlaneStress law_{make_law_field(GetParam())};
};

INSTANTIATE_TEST_SUITE_P(Registry, Laws, ::testing::ValuesIn(test::every_law()),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Laws, HaveNoStressAcrossTheLayer) {
  for (const double size : {1e-8, 1e-3, 0.1, 0.5}) {
    const LayerState at = law_.state(0, axes(), columns(size));
    const Tensor3<Pack> P = law_.law().P(0, at.H);
    const double largest = std::sqrt(dot(P, P)[0]);
    ASSERT_GT(largest, 0.0);
    for (int i = 0; i < 3; ++i) {
      const Pack across = P(i, 0) * axes()(2, 0) + P(i, 1) * axes()(2, 1) + P(i, 2) * axes()(2, 2);
      EXPECT_LT(std::abs(across[0]), 1e-13 * largest) << size;
      for (int a = 0; a < 2; ++a) {
        const Pack in_layer = P(i, 0) * axes()(a, 0) + P(i, 1) * axes()(a, 1) + P(i, 2) * axes()(a, 2);
        EXPECT_NEAR(at.P[a][i][0], in_layer[0], 1e-13 * largest) << size;
      }
    }
  }
}

TEST_P(Laws, HaveTheLeastEnergyOfAllThicknesses) {
  const LayerState at = law_.state(0, axes(), columns(0.2));
  const double least = law_.psi(0, at)[0];
  for (int i = 0; i < 3; ++i) {
    for (const double d : {-0.01, 0.01}) {
      LayerState other = at;
      for (int J = 0; J < 3; ++J) other.H(i, J) += d * axes()(2, J);
      EXPECT_GT(law_.psi(0, other)[0], least);
    }
  }
}

TEST_P(Laws, HaveTheTangentOfTheirStress) {
  for (const double size : {0.0, 0.01, 0.3}) {
    if (size == 0.0 && !is_smooth_at_rest(GetParam())) continue;
    const LayerColumns h = columns(size);
    LayerTangent T;
    law_.tangent(0, axes(), h, T);
    constexpr double step = 1e-5;
    double largest = 0.0, error = 0.0;
    for (std::size_t q = 0; q < 6; ++q) {
      LayerColumns ahead = h, behind = h;
      ahead[q / 3][q % 3] += step;
      behind[q / 3][q % 3] -= step;
      const LayerState next = law_.state(0, axes(), ahead), last = law_.state(0, axes(), behind);
      for (std::size_t p = 0; p < 6; ++p) {
        const double difference = (next.P[p / 3][p % 3][0] - last.P[p / 3][p % 3][0]) / (2.0 * step);
        largest = std::max(largest, std::abs(difference));
        error = std::max(error, std::abs(difference - T[6 * p + q][0]));
      }
    }
    ASSERT_GT(largest, 100.0);
    EXPECT_LT(error, 1e-7 * largest) << size;
  }
}

TEST_P(Laws, KeepTheirDigitsWhereTheStrainIsSmall) {
  if (!is_smooth_at_rest(GetParam())) return;
  // P is linear up to the square of the strain.
  constexpr double size = 1e-9;
  const LayerColumns h = columns(size);
  LayerTangent T;
  law_.tangent(0, axes(), stretches(1.0, 1.0), T);
  const LayerState at = law_.state(0, axes(), h);
  double largest = 0.0;
  for (std::size_t p = 0; p < 6; ++p) largest = std::max(largest, std::abs(at.P[p / 3][p % 3][0]));
  for (std::size_t p = 0; p < 6; ++p) {
    double linear = 0.0;
    for (std::size_t q = 0; q < 6; ++q) linear += T[6 * p + q][0] * h[q / 3][q % 3][0];
    EXPECT_NEAR(at.P[p / 3][p % 3][0], linear, 100.0 * size * largest);
  }
}

TEST(PlaneStress, OfHookesLawIsThatOfTextbooks) {
  const double E = 1000.0, nu = 0.3;
  const PlaneStress law(make_law_field(make_law("linear", E, nu)));
  const LayerColumns P = law.state(0, axes(), stretches(1.02, 0.99)).P;
  EXPECT_NEAR(along(P, 0), E / (1.0 - nu * nu) * (0.02 - nu * 0.01), 1e-11);
  EXPECT_NEAR(along(P, 1), E / (1.0 - nu * nu) * (-0.01 + nu * 0.02), 1e-11);
}

// P_1 = 2 (l_1 - 1/(l_1^3 l_2^2)) (c10 + c01 l_2^2) where the volume does not change (Treloar); nearly so here.
TEST(PlaneStress, OfMooneyRivlinIsThatOfTextbooks) {
  const double c10 = 300.0, c01 = 80.0;
  const PlaneStress law(make_law_field(make_law("mooney-rivlin", {{"c10", c10}, {"c01", c01}, {"bulk_modulus", 1e9}})));
  const double one_axis = 1.0 / std::sqrt(1.7);
  for (const auto& [first, second] : {std::pair{1.7, one_axis}, {1.5, 1.5}, {2.5, 2.5}, {2.0, 1.0}, {0.6, 1.2}}) {
    const LayerColumns P = law.state(0, axes(), stretches(first, second)).P;
    const auto expected = [&](double l1, double l2) {
      return 2.0 * (l1 - 1.0 / (l1 * l1 * l1 * l2 * l2)) * (c10 + c01 * l2 * l2);
    };
    const double largest = std::max(expected(first, second), c10);
    EXPECT_NEAR(along(P, 0), expected(first, second), 1e-5 * largest);
    EXPECT_NEAR(along(P, 1), expected(second, first), 1e-5 * largest);
  }
}

TEST(PlaneStress, OfAVanishingAreaHasNoStress) {
  const PlaneStress law(make_law_field(make_law("neo-hookean", 1000.0, 0.3)));
  EXPECT_TRUE(std::isnan(law.state(0, axes(), stretches(1.0, 0.0)).P[0][0][0]));
  EXPECT_FALSE(std::isfinite(law.psi(0, law.state(0, axes(), stretches(1.0, 0.0)))[0]));
}

}  // namespace
}  // namespace pliant::test_plane_stress
