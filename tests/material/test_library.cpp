// The measured materials against the measurements.
#include "material/library.hpp"
#include "material/loading.hpp"

#include <cmath>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_library {
namespace {

struct Point {
  double stretch;
  double stress;  ///< nominal [Pa]
};

double predicted(const LibraryMaterial& material, Loading loading, double stretch) {
  const ElasticLawSpec law = make_law(material.law, constants_of(material, 0.5));
  const auto state = loaded(law, loading, stretch);
  EXPECT_TRUE(state) << material.name << " " << stretch;
  return state ? nominal_stress(*state, loading) : NAN;
}

TEST(Library, EveryMaterialIsComplete) {
  std::set<std::string_view> names;
  for (const LibraryMaterial& material : material_library()) {
    EXPECT_TRUE(names.insert(material.name).second) << material.name;
    EXPECT_EQ(find_material(material.name), &material);
    EXPECT_NO_THROW(make_law(material.law, constants_of(material))) << material.name;
    EXPECT_GT(material.highest_stretch, 1.0);
    EXPECT_NE(material.source.find("doi:10."), std::string_view::npos) << material.name;
    for (const auto text : {material.tests, material.fit}) EXPECT_FALSE(text.empty());
    EXPECT_NE(library_text().find(material.name), std::string::npos);
  }
  EXPECT_EQ(find_material("cheese"), nullptr);
}

// Points of the tables of the Soft Robotics Materials Database, and of SoRoForge's (Cauchy stress over stretch), within
// the largest deviation that the library states, of the largest stress in the range.
TEST(Library, FitsAreAsGoodAsTheySay) {
  struct Measured {
    std::string_view name;
    double deviation;  ///< of the largest stress
    std::vector<Point> points;
  };
  const std::vector<Measured> tables{
      {"ecoflex-00-10",
       0.029,
       {{1.25, 4.11e3}, {1.5, 7.91e3}, {2, 14.79e3}, {2.5, 21.76e3}, {3, 31.117e3}, {4, 56.52e3}, {5, 85.893e3}}},
      {"ecoflex-00-30",
       0.011,
       {{1.25, 8.56e3}, {1.5, 16.89e3}, {2, 29.72e3}, {2.5, 40.08e3}, {3, 52.39e3}, {4, 80.15e3}, {5, 114.76e3}}},
      {"ecoflex-00-50",
       0.02,
       {{1.25, 12.26e3}, {1.5, 22.775e3}, {2, 40.95e3}, {2.5, 59.51e3}, {3, 79.005e3}, {4, 125.77e3}, {5, 183e3}}},
      {"dragon-skin-10", 0.043, {{1.25, 26.425e3}, {1.5, 52.996e3}, {2, 112.96e3}, {2.5, 190.58e3}, {3, 272.79e3}}},
      {"dragon-skin-20", 0.03, {{1.25, 72.147e3}, {1.5, 151.07e3}, {2, 318.36e3}, {2.5, 509.24e3}, {3, 722.26e3}}},
      {"dragon-skin-30", 0.03, {{1.25, 110.87e3}, {1.5, 213.92e3}, {2, 437.12e3}, {2.5, 689.38e3}, {3, 959.47e3}}},
      {"mold-star-16", 0.017, {{1.25, 51.411e3}, {1.5, 94.69e3}, {2, 185.5e3}, {2.5, 299.51e3}, {3, 433e3}}},
      {"sorta-clear-40", 0.011, {{1.25, 172.21e3}, {1.5, 307.07e3}, {2, 564.34e3}, {2.5, 864.54e3}, {3, 1216.8e3}}},
      {"rtv615", 0.011, {{1.25, 207.57e3}, {1.5, 384.82e3}, {2, 800.97e3}, {2.5, 1508.3e3}}},
      {"ninjaflex", 0.013, {{1.31303, 3.56164e6}, {1.62605, 5.05539e6}, {1.93908, 5.84188e6}}},
  };
  for (const Measured& measured : tables) {
    const LibraryMaterial* material = find_material(measured.name);
    ASSERT_NE(material, nullptr) << measured.name;
    EXPECT_NE(material->fit.find(fmt::format("at most {:.1f} %", 100.0 * measured.deviation)), std::string_view::npos);
    const double largest = predicted(*material, Loading::uniaxial, material->highest_stretch);
    for (const auto& [stretch, stress] : measured.points) {
      EXPECT_NEAR(predicted(*material, Loading::uniaxial, stretch), stress, measured.deviation * largest)
          << measured.name << " " << stretch;
    }
  }
}

// Treloar's tables [kgf/cm^2], and the sums of the squared residuals of Ogden's constants as computed elsewhere
// [MPa^2].
TEST(Library, OgdensConstantsDescribeTreloarsRubber) {
  const LibraryMaterial& rubber = *find_material("natural-rubber-treloar");
  const std::vector<Point> uniaxial{
      {1.02, .26}, {1.125, 1.37}, {1.24, 2.3},  {1.39, 3.23}, {1.585, 4.16}, {1.9, 5.1},   {2.18, 6},    {2.42, 6.9},
      {3.02, 8.8}, {3.57, 10.7},  {4.03, 12.5}, {4.76, 16.2}, {5.36, 19.9},  {5.75, 23.6}, {6.15, 27.4}, {6.4, 31},
      {6.6, 34.8}, {6.85, 38.5},  {7.05, 42.1}, {7.15, 45.8}, {7.25, 49.6},  {7.4, 53.3},  {7.5, 57},    {7.6, 64.4}};
  const std::vector<Point> equibiaxial{
      {1.03, .95},  {1.07, 1.6},  {1.12, 2.42}, {1.14, 2.62}, {1.2, 3.32},  {1.31, 4.43}, {1.42, 5.18}, {1.68, 6.6},
      {1.94, 7.78}, {2.49, 9.79}, {3.03, 12.6}, {3.43, 14.7}, {3.75, 17.4}, {4.07, 20.1}, {4.26, 22.5}, {4.45, 24.7}};
  const auto residual = [&](Loading loading, const std::vector<Point>& table) {
    constexpr double in_MPa = 0.0980665;
    double sum = 0.0;
    for (const auto& [stretch, stress] : table) {
      sum += std::pow(1e-6 * predicted(rubber, loading, stretch) - in_MPa * stress, 2);
    }
    return sum;
  };
  EXPECT_NEAR(residual(Loading::uniaxial, uniaxial), 2.29714, 1e-5);
  EXPECT_NEAR(residual(Loading::equibiaxial, equibiaxial), 0.0235900, 1e-7);
}

}  // namespace
}  // namespace pliant::test_library
