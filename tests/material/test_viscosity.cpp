// The laws of viscosity and their registry.
#include "material/viscosity_registry.hpp"
#include "states.hpp"

#include <set>

#include <gtest/gtest.h>

namespace pliant::test_viscosity {
namespace {

using namespace testing_states;

TEST(ViscosityRegistry, HasOneCompleteRowPerLaw) {
  std::set<std::string_view> names;
  for (const LawInfo& row : viscosity_laws()) {
    EXPECT_TRUE(names.insert(row.name).second);
    EXPECT_FALSE(row.formula.empty());
    EXPECT_FALSE(row.source.empty());
    EXPECT_FALSE(row.when_to_use.empty());
    EXPECT_FALSE(row.parameters.empty());
    for (const ParameterInfo& parameter : row.parameters) {
      EXPECT_FALSE(parameter.unit.empty());
      EXPECT_FALSE(parameter.meaning.empty());
    }
  }
  const std::set<std::string_view> expected{KelvinVoigt::name, Maxwell::name, Prony::name, StiffnessProportional::name,
                                            MassProportional::name};
  EXPECT_EQ(names, expected);
}

// What the input reads goes by these: each parameter into a member of its own, forms of a law told apart by their
// first.
TEST(ViscosityRegistry, HasAFormForEveryAlternative) {
  std::set<std::string_view> named, firsts;
  std::size_t index = 0;
  for (const ViscosityForm& form : viscosity_forms()) {
    EXPECT_EQ(form.blank.index(), index++);
    named.insert(name_of(form.blank));
    EXPECT_TRUE(firsts.insert(form.parameters.front().name).second) << form.parameters.front().name;
    EXPECT_FALSE(form.parameters.front().fallback);
    ASSERT_EQ(form.members.size(), form.parameters.size());
    ViscosityLaw law = form.blank;
    for (std::size_t k = 0; k < form.members.size(); ++k) {
      EXPECT_EQ(form.members[k](law), 0.0) << form.parameters[k].name;
      form.members[k](law) = static_cast<double>(k + 1);
    }
    for (std::size_t k = 0; k < form.members.size(); ++k) EXPECT_EQ(form.members[k](law), static_cast<double>(k + 1));
  }
  for (const LawInfo& row : viscosity_laws()) EXPECT_EQ(named.count(row.name), 1u) << row.name;
  EXPECT_EQ(named.size(), viscosity_laws().size());
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
TEST(ViscosityRegistry, TakesNoNegativeValuesAndZeroWhereItMeansSomething) {
  for (const LawInfo& row : viscosity_laws()) {
    for (const ParameterInfo& parameter : row.parameters) {
      EXPECT_TRUE(error_in(parameter, -1.0)) << parameter.name;
      EXPECT_FALSE(error_in(parameter, 1.0)) << parameter.name;
      EXPECT_TRUE(error_in(parameter, std::numeric_limits<double>::quiet_NaN())) << parameter.name;
      EXPECT_TRUE(error_in(parameter, std::numeric_limits<double>::infinity())) << parameter.name;
      EXPECT_EQ(error_in(parameter, 0.0).has_value(), parameter.name == "relaxation_time") << parameter.name;
    }
  }
}

// Against the formula as written, and in the manner of the laws of elasticity: C:D is the gradient of D:C:D/2.
TEST(IsotropicTensor, IsTwiceShearOnTheDeviatorAndBulkOnTheTrace) {
  const IsotropicTensor<double> C{3.0, 7.0};
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Matrix D = small_strain(random_matrix(seed, 1.0));
    const Matrix deviator = add_to_diagonal(D, -trace(D) / 3.0);
    const Matrix expected = add_to_diagonal(2.0 * 3.0 * deviator, 7.0 * trace(D));
    EXPECT_LE(relative_difference(C(D), expected), 1e-15);
    EXPECT_NEAR(0.5 * dot(D, C(D)), 3.0 * dot(deviator, deviator) + 3.5 * trace(D) * trace(D), 1e-14);
  }
}

}  // namespace
}  // namespace pliant::test_viscosity
