// The laws of viscosity and their registry.
#include "material/viscosity_registry.hpp"
#include "states.hpp"

#include <set>

#include <gtest/gtest.h>

namespace pliant {
namespace {

using namespace testing_states;

TEST(ViscosityRegistry, HasOneCompleteRowPerLawInOrder) {
  ASSERT_EQ(viscosity_laws().size(), std::variant_size_v<ViscosityVariant>);
  std::set<std::string_view> names;
  for (std::size_t n = 0; n < viscosity_laws().size(); ++n) {
    const LawInfo& row = viscosity_laws()[n];
    EXPECT_TRUE(names.insert(row.name).second);
    EXPECT_FALSE(row.formula.empty());
    EXPECT_FALSE(row.source.empty());
    EXPECT_FALSE(row.when_to_use.empty());
    std::vector<double> values;
    for (const ParameterInfo& parameter : row.parameters) {
      EXPECT_FALSE(parameter.unit.empty());
      EXPECT_FALSE(parameter.meaning.empty());
      values.push_back(1.0 + static_cast<double>(values.size()));
    }
    const ViscosityVariant law = make_viscosity(row.name, values, StrainRate::exact);
    EXPECT_EQ(law.index(), n);
    std::visit([&]<class L>(const L&) { EXPECT_EQ(L::name, row.name); }, law);
  }
}

TEST(ViscosityRegistry, GivesEachParameterItsPlace) {
  const auto kelvin_voigt =
      std::get<KelvinVoigt>(make_viscosity("kelvin-voigt", std::array{3.0, 5.0}, StrainRate::secant));
  EXPECT_EQ(kelvin_voigt.shear, 3.0);
  EXPECT_EQ(kelvin_voigt.bulk, 5.0);
  EXPECT_EQ(kelvin_voigt.rate, StrainRate::secant);
  const auto maxwell = std::get<Maxwell>(make_viscosity("maxwell", std::array{3.0, 5.0, 7.0}, StrainRate::exact));
  EXPECT_EQ(maxwell.shear_modulus, 3.0);
  EXPECT_EQ(maxwell.bulk_modulus, 5.0);
  EXPECT_EQ(maxwell.relaxation_time, 7.0);
}

TEST(ViscosityRegistry, NamesEveryFormOfTheStrainRateInOrder) {
  const std::array forms{StrainRate::secant, StrainRate::reconstructed, StrainRate::exact};
  ASSERT_EQ(strain_rates().size(), forms.size());
  std::set<std::string_view> names;
  for (std::size_t n = 0; n < forms.size(); ++n) {
    EXPECT_EQ(strain_rates()[n].rate, forms[n]);
    EXPECT_TRUE(names.insert(strain_rates()[n].name).second);
    EXPECT_FALSE(strain_rates()[n].formula.empty());
    EXPECT_FALSE(strain_rates()[n].when_to_use.empty());
  }
}

// A viscosity of nothing is none; a time of relaxation of nothing is a division by zero.
TEST(ViscosityRegistry, TellsEveryMistakeAtItsPlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto make = [](std::string_view name, const std::vector<double>& values) {
    return make_viscosity(name, values, StrainRate::exact, {"a.yaml", 3, 5});
  };
  EXPECT_NO_THROW(make("kelvin-voigt", {0.0, 0.0}));
  EXPECT_NO_THROW(make("maxwell", {0.0, 0.0, 1.0}));
  EXPECT_THROW(make("maxwell", {1.0, 1.0, 0.0}), InputError);
  EXPECT_THROW(make("kelvin-voigt", {nan, 0.0}), InputError);
  EXPECT_THROW(make("kelvin-voigt", {1.0, std::numeric_limits<double>::infinity()}), InputError);
  try {
    make("maxwell", {-1.0, 1.0, -2.0});
    FAIL() << "no exception";
  } catch (const InputError& e) {
    ASSERT_EQ(e.diagnostics().size(), 2u);
    const std::string text = e.what();
    EXPECT_NE(text.find("a.yaml:3:5"), std::string::npos);
    EXPECT_NE(text.find("shear_modulus is -1; it must be finite and at least 0"), std::string::npos);
    EXPECT_NE(text.find("relaxation_time is -2; it must be finite and above 0"), std::string::npos);
  }
  try {
    make("kelvin-voight", {});
    FAIL() << "no exception";
  } catch (const InputError& e) {
    for (const auto& row : viscosity_laws()) EXPECT_NE(std::string(e.what()).find(row.name), std::string::npos);
  }
}

// Against the formula as written, and in the manner of the laws of elasticity: C:D is the gradient of D:C:D/2.
TEST(IsotropicTensor, IsTwiceShearOnTheDeviatorAndBulkOnTheTrace) {
  const IsotropicTensor C{3.0, 7.0};
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Matrix D = small_strain(random_matrix(seed, 1.0));
    const Matrix deviator = add_to_diagonal(D, -trace(D) / 3.0);
    const Matrix expected = add_to_diagonal(2.0 * 3.0 * deviator, 7.0 * trace(D));
    EXPECT_LE(relative_difference(C(D), expected), 1e-15);
    EXPECT_NEAR(0.5 * dot(D, C(D)), 3.0 * dot(deviator, deviator) + 3.5 * trace(D) * trace(D), 1e-14);
  }
}

}  // namespace
}  // namespace pliant
