// What laws with fibres must do beyond having the right derivatives.
#include "material/registry.hpp"
#include "states.hpp"

#include <cfenv>
#include <limits>

#include <gtest/gtest.h>

namespace pliant::test_fibres {
namespace {

using namespace testing_states;

/// H of a stretch along the first family of the typical laws, with sides that keep the volume.
Matrix stretched_along_fibre(double stretch) {
  const auto f = typical_spec<HolzapfelOgden<double>>().directions[0];
  const double side = 1 / std::sqrt(stretch);
  return add_to_diagonal((stretch - side) * outer(Vector3<double>(f), Vector3<double>(f)), side - 1);
}

template <class L>
L without(L law) {
  if constexpr (requires { law.pull; }) {
    law.pull.a = 0.0;
  } else {
    law.along_f.a = law.along_s.a = 0.0;
  }
  return law;
}

template <class L>
class SlackFibres : public testing::Test {};
using LawsWithSlackFibres = testing::Types<HolzapfelGasserOgden<double>, HolzapfelOgden<double>>;
TYPED_TEST_SUITE(SlackFibres, LawsWithSlackFibres, NameOfLaw);

TYPED_TEST(SlackFibres, PullAndDoNotPush) {
  TypeParam law = typical<TypeParam>();
  if constexpr (requires { law.dispersion; }) {
    law.dispersion = 0.0;
    law.families[1] = law.families[0];  // else it is stretched where the first is not
  } else {
    law.along_s.a = 0.0;
  }
  const Matrix shorter = stretched_along_fibre(0.8), longer = stretched_along_fibre(1.2);
  EXPECT_EQ(energy(law, shorter), energy(without(law), shorter));
  EXPECT_EQ(norm(stress(law, shorter) - stress(without(law), shorter)), 0.0);
  EXPECT_GT(energy(law, longer), 1.1 * energy(without(law), longer));
}

/// Where the fibres go slack the stress has no jump.
TYPED_TEST(SlackFibres, GoSlackWithoutAJumpOfTheStress) {
  const TypeParam law = typical<TypeParam>();
  const double h = 1e-9;
  EXPECT_LE(norm(stress(law, stretched_along_fibre(1 + h)) - stress(law, stretched_along_fibre(1 - h))),
            10 * h * stiffness(law));
}

TEST(Guccione, EqualExponentsAreIsotropic) {
  ElasticLawSpec spec = typical_spec<Guccione<double>>();
  for (const std::size_t b : {1u, 2u, 3u}) spec.parameters[b] = 2.0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Matrix H = moderate_state(seed), E = green_lagrange(H);
    const auto law = std::get<Guccione<double>>(instantiate(spec));
    const double expected = 0.5 * law.C * std::expm1(2.0 * dot(E, E)) + law.volumetric.energy(volume_change(H));
    EXPECT_NEAR(energy(law, H), expected, 1e-14 * stiffness(law));
  }
}

/// Fibres of all directions alike: which they are makes no difference.
TEST(HolzapfelGasserOgden, FullDispersionIsIsotropic) {
  auto law = typical<HolzapfelGasserOgden<double>>();
  law.dispersion = 1.0 / 3.0;
  auto other = law;
  std::swap(other.families[0][0], other.families[0][2]);
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Matrix H = moderate_state(seed);
    EXPECT_NEAR(energy(law, H), energy(other, H), 1e-14 * stiffness(law));
  }
  law.dispersion = other.dispersion = 0.1;
  EXPECT_GT(std::abs(energy(law, moderate_state(1)) - energy(other, moderate_state(1))), 1e-4 * stiffness(law));
}

template <class L>
class ExponentialLaw : public testing::Test {};
using ExponentialLaws = testing::Types<Guccione<double>, HolzapfelGasserOgden<double>, HolzapfelOgden<double>>;
TYPED_TEST_SUITE(ExponentialLaw, ExponentialLaws, NameOfLaw);

TYPED_TEST(ExponentialLaw, EndsQuietlyBeyondItsExponents) {
  const auto law = typical<TypeParam>();
  for (const Matrix& H : {stretched_along_fibre(60.0), Matrix{{-3, 0, 0, 0, 0, 0, 0, 0, 0}},
                          stretched_along_fibre(std::numeric_limits<double>::quiet_NaN())}) {
    std::feclearexcept(FE_ALL_EXCEPT);
    const double psi = energy(law, H);
    const Matrix P = stress(law, H);
    const Tangent<double> A = stiffness_tensor(law, H);
    EXPECT_EQ(std::fetestexcept(FE_DIVBYZERO | FE_OVERFLOW), 0);
    EXPECT_EQ(psi, std::numeric_limits<double>::infinity());
    for (const double p : P.a) EXPECT_TRUE(std::isnan(p));
    for (const double a : A) EXPECT_TRUE(std::isnan(a));
  }
}

}  // namespace
}  // namespace pliant::test_fibres
