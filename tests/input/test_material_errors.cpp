// Mistakes in the materials of bodies are told once, at their place, in words that help.
#include "input/bad_input.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_material_errors {
namespace {

using test::mistakes;
using test::told;
using test::with_line;

constexpr const char* viscous =
    "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, viscosity: ";

/// Of line 2 with this viscosity.
struct BadViscosity {
  const char* value;    ///< '@' marks the place
  const char* message;  ///< a part of it
};

void PrintTo(const BadViscosity& bad, std::ostream* out) {
  *out << bad.value;
}

class BadViscosityOfABody : public ::testing::TestWithParam<BadViscosity> {};

TEST_P(BadViscosityOfABody, IsToldOnceAtItsPlace) {
  std::string line = viscous + std::string(GetParam().value) + "}]";
  const std::size_t marker = line.find('@');
  line.erase(marker, 1);
  const auto found = mistakes(with_line(2, line));
  ASSERT_EQ(found.size(), 1u) << told(found);
  EXPECT_EQ(to_string(found[0].where), "dir/a.yaml:2:" + std::to_string(marker + 1)) << told(found);
  EXPECT_NE(found[0].message.find(GetParam().message), std::string::npos) << told(found);
}

INSTANTIATE_TEST_SUITE_P(
    Viscosity, BadViscosityOfABody,
    ::testing::Values(
        BadViscosity{"@1", "'viscosity' must be a map of keys such as 'model:', not '1'"},
        BadViscosity{"@{shear: 1}", "missing key 'model' in viscosity"},
        BadViscosity{"{model: @kelvin, shear: 1}",
                     "'model' must be one of kelvin-voigt, maxwell, prony, stiffness-proportional, mass-proportional, "
                     "not 'kelvin'"},
        BadViscosity{"@[]", "'viscosity' must be a list with entries"},
        BadViscosity{"[{model: mass-proportional, decay_rate: 1}, @{model: mass-proportional}]",
                     "missing key 'decay_rate' in viscosity[1], which 'model: mass-proportional' needs"},
        BadViscosity{"{model: mass-proportional, decay_rate: @1 s}",
                     "'1 s' is a time, but a frequency [1/s] is expected"},
        BadViscosity{"@{model: prony, relaxation_time: 1}", "missing key 'ratio' in viscosity"},
        BadViscosity{"@{model: stiffness-proportional}", "missing key 'time' in viscosity"},
        BadViscosity{"{model: kelvin-voigt, shear: 1, @time: 1}",
                     "'time' can only be given with 'model: stiffness-proportional' in viscosity"},
        BadViscosity{"@{model: maxwell, relaxation_time: 1}",
                     "one of shear_modulus, shear_ratio is needed in viscosity with 'model: maxwell'"},
        BadViscosity{"{model: maxwell, relaxation_time: 1, shear_modulus: 1, @shear_ratio: 1}",
                     "only one of shear_modulus, shear_ratio can be given"},
        BadViscosity{"{model: maxwell, relaxation_time: 1, shear_ratio: 1, @bulk_modulus: 1}",
                     "'bulk_modulus' can only be given with 'shear_modulus'"},
        BadViscosity{"@{model: kelvin-voigt}", "missing key 'shear' in viscosity, which 'model: kelvin-voigt' needs"},
        BadViscosity{"@{model: maxwell, shear_modulus: 1}",
                     "missing key 'relaxation_time' in viscosity, which 'model: maxwell' needs"},
        BadViscosity{"{model: kelvin-voigt, shear: 1, @shear_modulus: 1}",
                     "'shear_modulus' can only be given with 'model: maxwell' in viscosity"},
        BadViscosity{
            "{model: maxwell, shear_modulus: 1, relaxation_time: 1, @rate: exact}",
            "'rate' can only be given with 'model: kelvin-voigt' or 'model: stiffness-proportional' in viscosity"},
        BadViscosity{"{model: kelvin-voigt, shear: 1, @bulks: 1}", "(did you mean 'bulk'?)"},
        BadViscosity{"{model: kelvin-voigt, shear: @-1}", "'shear' must be >= 0 [Pa*s], not '-1'"},
        BadViscosity{"{model: kelvin-voigt, shear: @20 Pa}",
                     "'20 Pa' is a pressure, but a viscosity [Pa*s] is expected"},
        BadViscosity{"{model: kelvin-voigt, shear: 1, rate: @exakt}", "(did you mean 'exact'?)"},
        BadViscosity{"{model: maxwell, shear_modulus: 1, relaxation_time: @0}", "'relaxation_time' must be > 0 [s]"}));

/// Of line 2 with this softening of a law with two moduli.
struct BadSoftening {
  std::string model;
  std::string rest;  ///< of the body and the input; '@' marks the place
  const char* message;
};

void PrintTo(const BadSoftening& bad, std::ostream* out) {
  *out << bad.model << " " << bad.rest;
}

class BadSofteningOfABody : public ::testing::TestWithParam<BadSoftening> {};

TEST_P(BadSofteningOfABody, IsToldOnceAtItsPlace) {
  const std::string text = "bodies: [{density: 1, elasticity: {model: " + GetParam().model +
                           ", youngs_modulus: 1, poissons_ratio: 0.3}, mullins: " + GetParam().rest;
  test::expect_told_once({2, text.c_str(), GetParam().message});
}

INSTANTIATE_TEST_SUITE_P(
    Softening, BadSofteningOfABody,
    ::testing::Values(BadSoftening{"neo-hookean", "@{m: 1}}]", "missing key 'r' in mullins"},
                      BadSoftening{"neo-hookean", "{r: @1, m: 1}}]", "'r' must be > 1"},
                      BadSoftening{"neo-hookean", "{r: 2, m: @-1}}]", "'m' must be >= 0"},
                      BadSoftening{"neo-hookean", "{r: 2, beta: @-1}}]", "'beta' must be >= 0"},
                      BadSoftening{"neo-hookean", "{r: 2, m: @1 mm}}]", "'1 mm' is a length"},
                      BadSoftening{"neo-hookean", "@{r: 2}}]", "'mullins' needs an 'm' or a 'beta' above 0"},
                      BadSoftening{"saint-venant-kirchhoff", "@{r: 2, m: 1}}]",
                                   "and model 'saint-venant-kirchhoff' has no separate volumetric part; use one of "},
                      BadSoftening{"neo-hookean", "@{r: 2, m: 1}, active: {fibre: [1, 0, 0], shortening: t}}]",
                                   "cannot follow a body whose fibres shorten"},
                      BadSoftening{"neo-hookean", "@{r: 2, m: 1 J/m^3}}]\nelement: P2\nvolumetric: mean-dilatation",
                                   "without its volumetric part, model 'neo-hookean' still feels a change of volume"}));

TEST(MaterialErrors, IncompressibleBodiesNeedPressuresAtTheEndOfEveryStep) {
  const std::vector<Override> set{
      {"volumetric", "mixed"}, {"time.method", "implicit-midpoint"}, {"initial.displacement", "[0.1*x, 0, 0]"}};
  const auto at = [&](const std::string& ratio) {
    return told(mistakes(with_line(2,
                                   "bodies: [{density: 1, elasticity: {model: neo-hookean, youngs_modulus: 1, "
                                   "poissons_ratio: " +
                                       ratio + "}}]"),
                         set));
  };
  EXPECT_EQ(at("0.4999"), "");
  const std::string errors = at("0.5");
  for (const char* text :
       {"--set time.method=implicit-midpoint: an incompressible body needs a stiffly accurate method",
        "--set initial.displacement=[0.1*x, 0, 0]: an incompressible body must start undeformed"}) {
    EXPECT_NE(errors.find(text), std::string::npos) << errors;
  }
}

TEST(MaterialErrors, DensityIsNeededByDampingOfMassAlsoWithoutInertia) {
  const std::string weightless =
      "bodies: [{elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, viscosity: {model: "
      "mass-proportional, decay_rate: 1}}]";
  const std::vector<Override> set{{"time.method", "quasistatic"}, {"loads", "[]"}};
  EXPECT_NE(told(mistakes(with_line(2, weightless), set)).find("which mass-proportional damping needs"),
            std::string::npos);
}

TEST(MaterialErrors, DensityIsNeededByGravityAlsoWithoutInertia) {
  const std::string weightless =
      "bodies: [{volume: a, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]";
  std::vector<Override> set{{"time.method", "static"}};
  EXPECT_NE(told(mistakes(with_line(2, weightless), set)).find("which gravity needs"), std::string::npos);
  set.push_back({"loads.0.volume", "b"});
  EXPECT_EQ(told(mistakes(with_line(2, weightless), set)), "");
  set.back() = {"loads", "[]"};
  EXPECT_EQ(told(mistakes(with_line(2, weightless), set)), "");
}

}  // namespace
}  // namespace pliant::test_material_errors
