#include "base/limits.hpp"
#include "material/lame.hpp"
#include "material/registry.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test_registry {
namespace {

TEST(Registry, HasOneCompleteRowPerLawInOrder) {
  ASSERT_EQ(elastic_laws().size(), std::variant_size_v<ElasticLawVariant>);
  std::set<std::string_view> names;
  for (std::size_t n = 0; n < elastic_laws().size(); ++n) {
    const LawInfo& row = elastic_laws()[n];
    EXPECT_TRUE(names.insert(row.name).second);
    EXPECT_FALSE(row.formula.empty());
    EXPECT_FALSE(row.source.empty());
    EXPECT_FALSE(row.when_to_use.empty());
    for (const ParameterInfo& parameter : row.parameters) {
      EXPECT_FALSE(parameter.unit.empty());
      EXPECT_LT(parameter.lower, parameter.upper);
    }
    const ElasticLawVariant law = instantiate(typical_law(n));
    EXPECT_EQ(law.index(), n);
    EXPECT_EQ(static_cast<int>(row.directions.size()), typical_law(n).traits().num_directions) << row.name;
    EXPECT_EQ(std::visit([]<class L>(const L&) { return L::name; }, law), row.name);
    for (const ParameterInfo& parameter : row.parameters) {
      EXPECT_EQ(error_in(parameter, parameter.typical), std::nullopt) << row.name << " " << parameter.name;
    }
  }
}

TEST(Registry, ALawIsAddedOnce) {
  EXPECT_THROW(add_elastic_law(elastic_laws().front(), law_kind<Yeoh>()), std::invalid_argument);
  EXPECT_EQ(elastic_laws().size(), std::variant_size_v<ElasticLawVariant>);
}

TEST(Registry, TellsEveryMistakeAtItsPlace) {
  try {
    make_law("neo-hooke", 1.0, 0.3, {"a.yaml", 3, 5});
    FAIL() << "no exception";
  } catch (const InputError& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("a.yaml:3:5"), std::string::npos);
    for (const auto& row : elastic_laws()) EXPECT_NE(text.find(row.name), std::string::npos);
  }
  try {
    make_law("neo-hookean", -1.0, 0.6, {"a.yaml", 3, 5});
    FAIL() << "no exception";
  } catch (const InputError& e) {
    ASSERT_EQ(e.diagnostics().size(), 2u);
    const std::string text = e.what();
    EXPECT_NE(text.find("youngs_modulus"), std::string::npos);
    EXPECT_NE(text.find("poissons_ratio"), std::string::npos);
  }
  EXPECT_THROW(make_law("linear", nan, 0.3), InputError);
  EXPECT_THROW(make_law("linear", 1.0, nan), InputError);
  EXPECT_THROW(make_law("linear", 1.0, -1.0), InputError);
  EXPECT_THROW(make_law("linear", std::numeric_limits<double>::infinity(), 0.3), InputError);
  EXPECT_NO_THROW(make_law("linear", 1.0, 0.0));
  EXPECT_NO_THROW(make_law("linear", 1.0, -0.5));
}

/// Any two of the constants give the same law.
TEST(Constants, AnyTwoOfTheElasticConstants) {
  const Lame c = lame(1e6, 0.4);
  const std::map<std::string, double> all{{"youngs_modulus", 1e6},
                                          {"poissons_ratio", 0.4},
                                          {"shear_modulus", c.mu},
                                          {"bulk_modulus", bulk_modulus(c)},
                                          {"lame_lambda", c.lambda}};
  for (const auto& [first, a] : all) {
    for (const auto& [second, b] : all) {
      if (first == second) continue;
      for (const char* name : {"neo-hookean", "neo-hookean-isochoric"}) {
        const auto rest = make_law(name, {{first, a}, {second, b}}).at_rest();
        ASSERT_TRUE(rest);
        EXPECT_NEAR(rest->mu, c.mu, 1e-9 * c.mu) << first << " " << second;
        EXPECT_NEAR(rest->lambda, c.lambda, 1e-9 * c.lambda) << first << " " << second;
      }
    }
  }
}

TEST(Constants, PoissonsRatioStandsForTheBulkModulus) {
  const auto rest = make_law("mooney-rivlin", {{"c10", 3e5}, {"c01", 1e5}, {"poissons_ratio", 0.45}}).at_rest();
  ASSERT_TRUE(rest);
  EXPECT_DOUBLE_EQ(rest->mu, 8e5);
  EXPECT_NEAR(poissons_ratio(*rest), 0.45, 1e-14);
}

// FEBio's lambda, or what stands for it at small strain: lambda + 4 c2 is Lame's parameter there.
TEST(Constants, OfCoupledMooneyRivlin) {
  const auto lambda_of = [](const char* key, double value) {
    return make_law("mooney-rivlin-coupled", {{"c1", 3e5}, {"c2", 1e5}, {key, value}}).parameters[2];
  };
  EXPECT_EQ(lambda_of("lambda", 1e6), 1e6);
  const Lame rest{8e5, 1.4e6};
  EXPECT_NEAR(lambda_of("bulk_modulus", bulk_modulus(rest)), 1e6, 1e-9);
  EXPECT_NEAR(lambda_of("poissons_ratio", poissons_ratio(rest)), 1e6, 1e-8);
  EXPECT_EQ(lambda_of("poissons_ratio", 0.5), infinity);
  EXPECT_THROW(make_law("mooney-rivlin-coupled", {{"c1", 3e5}, {"c2", 1e5}}), InputError);
  EXPECT_THROW(make_law("mooney-rivlin-coupled", {{"c1", 3e5}, {"c2", 1e5}, {"lambda", 1e6}, {"bulk_modulus", 1e6}}),
               InputError);
}

TEST(Constants, MistakesAreTold) {
  const auto message = [](std::string_view name, const GivenConstants& constants) -> std::string {
    try {
      make_law(name, constants);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no exception";
  };
  EXPECT_NE(message("linear", {{"youngs_modulus", 1.0}}).find("needs two of"), std::string::npos);
  EXPECT_NE(
      message("linear", {{"youngs_modulus", 1.0}, {"poissons_ratio", 0.3}, {"shear_modulus", 1.0}}).find("3 given"),
      std::string::npos);
  EXPECT_NE(message("linear", {{"youngs_modulus", 1.0}, {"poissons_ratio", 0.3}, {"c10", 1.0}})
                .find("'c10' is not a parameter of linear"),
            std::string::npos);
  EXPECT_NE(message("mooney-rivlin", {{"c10", 1.0}, {"bulk_modulus", 1.0}}).find("missing key 'c01'"),
            std::string::npos);
  EXPECT_NE(message("mooney-rivlin", {{"c10", 1.0}, {"c01", -2.0}, {"bulk_modulus", 1.0}}).find("unstable"),
            std::string::npos);
  EXPECT_NE(message("linear", {{"youngs_modulus", 4.0}, {"shear_modulus", 1.0}}).find("unstable"), std::string::npos);
}

TEST(Lame, ConvertsThereAndBack) {
  for (const double nu : {-0.5, 0.0, 0.3, 0.499}) {
    const Lame c = lame(7e9, nu);
    EXPECT_NEAR(youngs_modulus(c), 7e9, 1e-4);  // nu near 1/2 costs three digits
    EXPECT_NEAR(poissons_ratio(c), nu, 1e-13);
    EXPECT_NEAR(bulk_modulus(c), 7e9 / (3 * (1 - 2 * nu)), 1e-12 * bulk_modulus(c));
  }
}

}  // namespace
}  // namespace pliant::test_registry
