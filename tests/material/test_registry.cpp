#include "material/lame.hpp"
#include "material/registry.hpp"

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace pliant {
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
    const ElasticLawVariant law = make_law(row.name, 1e6, 0.4);
    EXPECT_EQ(law.index(), n);
    std::visit(
        [&]<class L>(const L& l) {
          EXPECT_EQ(L::name, row.name);
          EXPECT_DOUBLE_EQ(l.mu, 1e6 / 2.8);
          EXPECT_DOUBLE_EQ(l.lambda, 0.4e6 / (1.4 * 0.2));
        },
        law);
  }
}

TEST(Registry, TellsEveryMistakeAtItsPlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  try {
    make_law("neo-hooke", -1.0, 0.5, {"a.yaml", 3, 5});
    FAIL() << "no exception";
  } catch (const InputError& e) {
    ASSERT_EQ(e.diagnostics().size(), 3u);
    const std::string text = e.what();
    EXPECT_NE(text.find("a.yaml:3:5"), std::string::npos);
    for (const auto& row : elastic_laws()) EXPECT_NE(text.find(row.name), std::string::npos);
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

TEST(Lame, ConvertsThereAndBack) {
  for (const double nu : {-0.5, 0.0, 0.3, 0.499}) {
    const Lame c = lame(7e9, nu);
    EXPECT_NEAR(youngs_modulus(c), 7e9, 1e-4);  // nu near 1/2 costs three digits
    EXPECT_NEAR(poissons_ratio(c), nu, 1e-13);
    EXPECT_NEAR(bulk_modulus(c), 7e9 / (3 * (1 - 2 * nu)), 1e-12 * bulk_modulus(c));
  }
}

}  // namespace
}  // namespace pliant
