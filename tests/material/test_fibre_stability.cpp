// Where laws with fibres stop being stable, against conditions in closed form.
#include "material/fibre_stability.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_fibre_stability {
namespace {

StableFibreStretches stable(std::string_view law, const GivenConstants& constants) {
  const auto found = stable_fibre_stretches(make_law(law, constants));
  EXPECT_TRUE(found);
  return found.value();
}

TEST(FibreStability, IsNothingForIsotropicLaws) {
  EXPECT_FALSE(stable_fibre_stretches(make_law("neo-hookean", 1e5, 0.4)));
}

// A shear wave along pressed fibres, m (x) f with m normal to f, has the second derivative of the energy
//   S_ff + 2 dE_fm dS_fm = C e^Q (bf E_ff + bfs / (2 l)),  E_ff = (l^2 - 1) / 2,  dE_fm = 1 / (2 sqrt(l))
// at the stretch l of the fibres. It vanishes where bf (l^2 - 1) + bfs / l = 0: the fibres buckle.
TEST(FibreStability, GuccionesFibresBuckleInCompression) {
  const double bf = 20.0, bfs = 4.0;
  const StableFibreStretches at =
      stable("guccione", {{"C", 1e4}, {"bf", bf}, {"bt", 4.0}, {"bfs", bfs}, {"bulk_modulus", 1e6}});
  ASSERT_EQ(at.ways.size(), 2u);
  const double l = at.ways[0].compression;
  const double left = bf * (l * l - 1.0) + bfs / l;
  EXPECT_GT(left, -1e-6);
  EXPECT_LT(left, 0.3);  // waves askew to the fibres may be the first
  EXPECT_GT(l, 0.5);
  // Stretched fibres press the plane across them: bt (E_ss + 1 / (2 l)) = bt (1 / l - 1 / 2).
  EXPECT_NEAR(at.ways[0].tension, 2.0, 1e-6);
  EXPECT_NE(in_words(at, 0.3, 4.0).find("along the fibres down to a stretch of 0.8"), std::string::npos)
      << in_words(at, 0.3, 4.0);
}

// Fibres that do not push, in a matrix whose exponential is convex.
TEST(FibreStability, HolzapfelAndOgdensTypicalLawHasNoEnd) {
  std::size_t row = 0;
  while (row < elastic_laws().size() && elastic_laws()[row].name != "holzapfel-ogden") ++row;
  ASSERT_LT(row, elastic_laws().size());
  const auto at = stable_fibre_stretches(typical_law(row));
  ASSERT_TRUE(at);
  EXPECT_EQ(at->ways.size(), 3u);
  EXPECT_EQ(in_words(*at, 0.3, 4.0), "");
}

}  // namespace
}  // namespace pliant::test_fibre_stability
