// Where laws of rubber stop being stable, against Mooney and Rivlin's closed forms.
#include "material/stability.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_stability {
namespace {

constexpr double rounding = 1e-7;  // of a stretch found by halving

StableStretches stable(std::string_view law, GivenConstants constants) {
  constants.emplace("poissons_ratio", 0.5);
  const auto found = stable_stretches(make_law(law, constants));
  EXPECT_TRUE(found);
  return found.value();
}

StableStretches stable_mooney(double ratio) {
  return stable("mooney-rivlin", {{"c10", 1e5}, {"c01", -1e5 / ratio}});
}

// Of the law U1 (I1 - 3) + U2 (I2 - 3), in U1/|U2|, U2 below 0: the force in equibiaxial tension, 2 (l - l^-5) (U1 + U2
// l^2), is largest where U1/|U2| is `force`, and the tangent in logarithmic strains is singular where it is `tangent`.
TEST(Stability, OfMooneyRivlinInEquibiaxialTension) {
  for (const double l : {1.2, 1.5, 2.5}) {
    const double force = 3.0 * (l * l + std::pow(l, -4)) / (1.0 + 5.0 * std::pow(l, -6));
    const double tangent = (2.0 * std::pow(l, 4) + std::pow(l, -2)) / (l * l + 2.0 * std::pow(l, -4));
    ASSERT_GT(force, tangent);  // it is passed first
    const StableStretches at = stable_mooney(force);
    EXPECT_NEAR(at.equibiaxial, l, rounding * l);
    EXPECT_NE(in_words(at, 0.3, 4.0).find("in equibiaxial tension up to a stretch of"), std::string::npos);
  }
}

// Uniaxial compression to l is equibiaxial tension to l^-1/2, but its force, 2 (l - l^-2) (U1 + U2/l), is monotone
// longer.
TEST(Stability, OfMooneyRivlinInCompression) {
  for (const double l : {0.4, 0.6, 0.8}) {
    const double force = 3.0 * std::pow(l, -4) / (1.0 + 2.0 * std::pow(l, -3));
    const double tangent = (2.0 / (l * l) + l) / (1.0 / l + 2.0 * l * l);
    const StableStretches at = stable_mooney(std::max(force, tangent));
    EXPECT_NEAR(at.compression, l, rounding * l);
  }
}

// The force 2 (l - l^-2) (c10 + 2 c20 (I1 - 3)) of Yeoh's law with c20 below 0 has its maximum at l.
TEST(Stability, OfYeohsLawInTension) {
  for (const double l : {1.5, 2.0, 3.0}) {
    const double a = l - std::pow(l, -2), da = 1.0 + 2.0 * std::pow(l, -3), i1 = l * l + 2.0 / l - 3.0;
    const double c20 = -da / (2.0 * (da * i1 + 2.0 * a * a));  // c10 = 1, dI1 = 2 a
    EXPECT_NEAR(stable("yeoh", {{"c10", 1.0}, {"c20", c20}}).tension, l, rounding * l);
  }
}

TEST(Stability, ConvexLawsHaveNoEnd) {
  for (const auto* name : {"neo-hookean", "neo-hookean-isochoric", "mooney-rivlin", "mooney-rivlin-5",
                           "mooney-rivlin-coupled", "yeoh", "gent", "arruda-boyce", "ogden"}) {
    const auto row = std::ranges::find(elastic_laws(), std::string_view(name), &LawInfo::name) - elastic_laws().begin();
    const auto found = stable_stretches(typical_law(static_cast<std::size_t>(row)));
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(in_words(*found, 0.1001, 9.999), "") << name;
  }
  EXPECT_FALSE(stable_stretches(make_law("linear", 1.0, 0.3)));
  EXPECT_FALSE(stable_stretches(make_law("arap", {{"shear_modulus", 1.0}})));
}

// Ogden's terms are convex where mu_p is above 0 (in this scaling), whatever the exponent; a term that is not spoils
// it.
TEST(Stability, OfOgdensLawDependsOnTheSigns) {
  const StableStretches good = stable("ogden", {{"mu1", 3e5}, {"alpha1", 1.3}, {"mu2", 1e5}, {"alpha2", -2.0}});
  EXPECT_EQ(in_words(good, 0.1001, 9.999), "");
  const StableStretches bad = stable("ogden", {{"mu1", 3e5}, {"alpha1", 1.3}, {"mu2", -1e4}, {"alpha2", 5.0}});
  EXPECT_LT(bad.tension, 3.0);
  EXPECT_GT(bad.tension, 1.1);
}

// At the three ways of stretching themselves, with the volume of the state left aside, and in between.
TEST(Stability, LimitsOfStatesLieBetweenThoseOfTests) {
  const StableStretches at{2.0, 0.1, 1.8, 1.5};
  for (const double J : {1.0, 1.1}) {
    const double c = std::cbrt(J);
    const auto limit = [&](double l, double l2) { return at.limit({c * l, c * l2, c / (l * l2)}) / c; };
    EXPECT_NEAR(limit(1.3, std::pow(1.3, -0.5)), 2.0, 1e-12);
    EXPECT_NEAR(limit(1.3, 1.0), 1.8, 1e-12);
    EXPECT_NEAR(limit(1.3, 1.3), 1.5, 1e-12);
    EXPECT_NEAR(limit(1.3, std::pow(1.3, -0.25)), std::sqrt(2.0 * 1.8), 1e-12);
  }
  // Uniaxial compression is equibiaxial tension.
  const StableStretches pressed{2.0, 0.64, 1.8, 1.5};
  EXPECT_NEAR(pressed.limit({1.1, 1.1, 1.0 / 1.21}), 1.25, 1e-12);
}

}  // namespace
}  // namespace pliant::test_stability
