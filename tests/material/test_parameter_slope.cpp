// The derivatives of the isotropic laws by their parameters are those that differences show, and specimens follow them.
#include "material/constants.hpp"
#include "material/law_field.hpp"
#include "material/loading.hpp"
#include "material/parameter_slope.hpp"
#include "material/volume_split.hpp"
#include "states.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_parameter_slope {
namespace {

using testing_states::moderate_state;

std::vector<std::size_t> isotropic_laws() {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    if (has_parameter_slopes(typical_law(row))) rows.push_back(row);
  }
  return rows;
}

std::vector<Dual<double>> seeded(const std::vector<double>& parameters, std::size_t seed) {
  std::vector<Dual<double>> duals(parameters.begin(), parameters.end());
  duals[seed].slope = 1.0;
  return duals;
}

class EveryIsotropicLaw : public testing::TestWithParam<std::size_t> {};

TEST_P(EveryIsotropicLaw, HasTheStressOfTheLawAndItsSlopes) {
  const ElasticLawSpec law = typical_law(GetParam());
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto H = moderate_state(seed);
    const auto reference = testing_states::stress(instantiate(law), H);
    for (std::size_t p = 0; p < law.parameters.size(); ++p) {
      const auto dual = dual_stress(law, seeded(law.parameters, p), H);
      const auto at = [&](double change) {
        ElasticLawSpec other = law;
        other.parameters[p] += change;
        return testing_states::stress(instantiate(other), H);
      };
      const double h = 1e-4 * std::abs(law.parameters[p]);
      // Extrapolated once: the error is h^4 and 1e-16/h of the stress.
      const auto difference = [&](double step) { return (1.0 / (2.0 * step)) * (at(step) - at(-step)); };
      const auto expected = (1.0 / 3.0) * (4.0 * difference(0.5 * h) - difference(h));
      double size = 0.0;
      for (const double entry : reference.a) size = std::max(size, std::abs(entry));
      for (std::size_t n = 0; n < 9; ++n) {
        EXPECT_NEAR(dual.a[n].value, reference.a[n], 1e-13 * size);
        EXPECT_NEAR(dual.a[n].slope * law.parameters[p], expected.a[n] * law.parameters[p], 1e-9 * size)
            << law.info().parameters[p].name << ", entry " << n;
      }
    }
  }
}

TEST_P(EveryIsotropicLaw, HasTheSlopesOfTheModuliAtRest) {
  const ElasticLawSpec law = typical_law(GetParam());
  double seen = 0.0;
  for (std::size_t p = 0; p < law.parameters.size(); ++p) {
    const auto dual = dual_at_rest(law, seeded(law.parameters, p));
    ElasticLawSpec other = law;
    other.parameters[p] *= 1.0 + 1e-3;
    const Lame rest = law.at_rest().value(), changed = other.at_rest().value();
    EXPECT_EQ(dual.mu.value, rest.mu);
    EXPECT_NEAR(dual.mu.slope * 1e-3 * law.parameters[p], changed.mu - rest.mu, 1e-9 * rest.mu);
    EXPECT_NEAR(dual.lambda.slope * 1e-3 * law.parameters[p], changed.lambda - rest.lambda, 1e-9 * rest.mu);
    seen += std::abs(dual.mu.slope);
  }
  EXPECT_GT(seen, 0.0);
}

class EveryLawWithAVolumetricPart : public testing::TestWithParam<std::size_t> {};

TEST_P(EveryLawWithAVolumetricPart, IsIncompressibleInTheLimit) {
  ElasticLawSpec law = typical_law(GetParam());
  const auto split = split_volume(law);
  for (std::size_t p = 0; p < law.parameters.size(); ++p) {
    const auto name = law.info().parameters[p].name;
    if (name == "bulk_modulus" || name == "lame_lambda" || name == "lambda") law.parameters[p] = 1e12;
  }
  for (const Loading loading : {Loading::uniaxial, Loading::equibiaxial, Loading::pure_shear, Loading::simple_shear}) {
    for (const double amount : {0.8, 1.4}) {
      const auto limit = loaded_incompressible(split->rest, loading, amount);
      const auto stiff = loaded(law, loading, amount);
      ASSERT_TRUE(stiff.has_value());
      const double expected = nominal_stress(limit, loading);
      EXPECT_NEAR(nominal_stress(*stiff, loading), expected, 1e-4 * std::abs(expected)) << amount;
      EXPECT_GT(std::abs(expected), 1e3);
      for (const int k : free_entries(loading)) EXPECT_NEAR(limit.P(k, k), 0.0, 1e-9 * std::abs(expected));
    }
  }
}

std::vector<std::size_t> split_laws() {
  std::vector<std::size_t> rows = isotropic_laws();
  std::erase_if(rows, [](std::size_t row) { return !split_volume(typical_law(row)); });
  return rows;
}

std::string name_of_row(const testing::TestParamInfo<std::size_t>& row) {
  std::string name(elastic_laws()[row.param].name);
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryIsotropicLaw, testing::ValuesIn(isotropic_laws()), name_of_row);
INSTANTIATE_TEST_SUITE_P(Registry, EveryLawWithAVolumetricPart, testing::ValuesIn(split_laws()), name_of_row);

TEST(Constants, HaveTheSlopesOfTheParametersThatFollow) {
  // Every pair of constants of a law with two, and Poisson's ratio instead of a bulk modulus.
  struct Given {
    std::string law;
    std::vector<std::string> keys;
    std::vector<double> values;
  };
  std::vector<Given> all{{"mooney-rivlin", {"c10", "c01", "poissons_ratio"}, {2e5, 3e4, 0.45}}};
  const auto constants = elastic_constants();
  const std::vector<double> values{1e6, 0.35, 1e6 / 2.7, 1e6 / 0.9, 1e6 * 0.35 / (1.35 * 0.3)};
  for (std::size_t i = 0; i < constants.size(); ++i) {
    for (std::size_t j = i + 1; j < constants.size(); ++j) {
      all.push_back(
          {"neo-hookean", {std::string(constants[i].name), std::string(constants[j].name)}, {values[i], values[j]}});
    }
  }
  for (const Given& given : all) {
    std::size_t row = 0;
    while (elastic_laws()[row].name != given.law) ++row;
    const ConstantsRule rule(row, given.keys, {});
    const auto plain = rule(std::span<const double>(given.values));
    for (std::size_t k = 0; k < given.keys.size(); ++k) {
      const auto duals = rule(std::span<const Dual<double>>(seeded(given.values, k)));
      const double h = 1e-5 * given.values[k];
      auto more = given.values, less = given.values;
      more[k] += h;
      less[k] -= h;
      const auto right = rule(std::span<const double>(more)), left = rule(std::span<const double>(less));
      for (std::size_t p = 0; p < plain.size(); ++p) {
        EXPECT_EQ(duals[p].value, plain[p]);
        EXPECT_NEAR(duals[p].slope * given.values[k], (right[p] - left[p]) / (2.0 * h) * given.values[k],
                    1e-7 * (std::abs(plain[p]) + std::abs(duals[p].slope * given.values[k])))
            << given.law << " by " << given.keys[k];
      }
    }
  }
}

TEST(LoadingPath, GoesOnFromWhereItIs) {
  const ElasticLawSpec law = typical_law(2);
  LoadingPath path(law, Loading::pure_shear);
  for (const double amount : {1.3, 2.1, 1.7, 1.0}) {
    const auto state = path.to(amount);
    const auto alone = loaded(law, Loading::pure_shear, amount);
    ASSERT_TRUE(state && alone);
    EXPECT_NEAR(nominal_stress(*state, Loading::pure_shear), nominal_stress(*alone, Loading::pure_shear), 1e-6);
    EXPECT_EQ(state->H(1, 1), 0.0);
  }
}

TEST(Loading, VolumetricKeepsTheShapeAndHasTheVolume) {
  const auto state = loaded(make_law("neo-hookean", 1e6, 0.4), Loading::volumetric, 0.8);
  ASSERT_TRUE(state.has_value());
  EXPECT_NEAR(volume_change(state->H), -0.2, 1e-14);
  EXPECT_NEAR(state->P(0, 0), state->P(2, 2), 1e-9);
}

}  // namespace
}  // namespace pliant::test_parameter_slope
