// What an input may mean, but seldom does, is told with its place; what is usual is not. What only a mesh tells:
// tests/program/test_errors.py.
#include "input/bad_input.hpp"
#include "model/warnings.hpp"

#include <gtest/gtest.h>

namespace pliant::test_warnings {
namespace {

/// As users read them; all are of the severity.
std::vector<std::string> texts(Severity severity, const std::vector<Diagnostic>& diagnostics) {
  std::vector<std::string> texts;
  for (const Diagnostic& d : diagnostics) {
    EXPECT_EQ(d.severity, severity) << d.message;
    texts.push_back(to_string(d));
  }
  return texts;
}

std::vector<std::string> warnings_of(const std::string& text, const std::vector<Override>& overrides = {}) {
  return texts(Severity::warning, warnings_about(read_input(text, "a.yaml", overrides)));
}

std::vector<std::string> warnings(const std::string& time, const std::string& more, const std::string& every = "") {
  return warnings_of(test::with_line(5, "time: {" + time + "}") + more,
                     every.empty() ? std::vector<Override>{} : std::vector<Override>{{"output.every", every}});
}

TEST(Advice, StepsShouldNotBeLongerThanTheTimeBetweenFrames) {
  const auto told = warnings("step: 0.01, end: 1", "output: {every: 4 ms}");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].find("a.yaml:6:17: "), 0u) << told[0];
  EXPECT_NE(told[0].find("every 0.004 s, but a step is 0.01 s long"), std::string::npos) << told[0];
  EXPECT_EQ(warnings("method: quasistatic, step: 0.01, end: 1", "output: {every: 4 ms}").size(), 1u);
  EXPECT_EQ(warnings("step: 0.01, end: 1", "", "0.004").size(), 1u);
}

TEST(Advice, ListsWithoutBlanksAreTaken) {
  for (const char* list : {"[0,45,0]", "[0, 45, 0]", "[0,0, 1]", "[\"0\",45, 0]", "[0.5,45, 0]", "[0,\n  45, 0]"}) {
    const std::string line = "constraints: [{surface: clamp, displacement: " + std::string(list) + "}]";
    EXPECT_EQ(warnings_of(test::with_line(3, line)), std::vector<std::string>{}) << list;
  }
}

TEST(Advice, StepFilesNeedNoScale) {
  const auto told = [](const std::string& mesh) { return warnings_of(test::with_line(1, "mesh: {" + mesh + "}")); };
  ASSERT_EQ(told("file: a.step, scale: 0.001").size(), 1u);
  EXPECT_EQ(told("file: a.step, scale: 0.001")[0].find("a.yaml:1:14: a STEP file"), 0u);
  EXPECT_EQ(told("file: a.step"), std::vector<std::string>{});
  EXPECT_EQ(told("file: a.step, scale: 2"), std::vector<std::string>{});
  EXPECT_EQ(told("file: a.geo, scale: 0.001"), std::vector<std::string>{});
}

/// What is told of the good input with one line replaced.
std::vector<std::string> told_of(std::size_t line, const std::string& replacement) {
  return warnings_of(test::with_line(line, replacement));
}

struct Doubtful {
  std::size_t line;
  const char* replacement;
  const char* message;
};
void PrintTo(const Doubtful& d, std::ostream* out) {
  *out << d.replacement;
}

class Warning : public ::testing::TestWithParam<Doubtful> {};

TEST_P(Warning, IsToldOnceWithItsPlace) {
  const auto& [line, replacement, message] = GetParam();
  const auto told = told_of(line, replacement);
  ASSERT_EQ(told.size(), 1u) << testing::PrintToString(told);
  EXPECT_EQ(told[0].find("a.yaml:"), 0u) << told[0];
  EXPECT_NE(told[0].find(message), std::string::npos) << told[0];
}

INSTANTIATE_TEST_SUITE_P(
    Inputs, Warning,
    ::testing::Values(
        Doubtful{2, "bodies: [{density: 1e-9, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0.4}}]",
                 "with this density shear waves travel at 1.9e+04 m/s"},
        Doubtful{2, "bodies: [{density: 1000, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0.4}}]",
                 "shear waves travel at 0.019 m/s"},
        // A megapascal was meant, whatever else the body has.
        Doubtful{2,
                 "bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 0.3, poissons_ratio: 0.4}, "
                 "viscosity: {model: kelvin-voigt, shear: 100 Pa*s}}]",
                 "shear waves travel at 0.01 m/s"},
        Doubtful{2,
                 "bodies: [{density: 1000, elasticity: {model: linear, youngs_modulus: 1 MPa, shear_modulus: 1 MPa}}]",
                 "these constants give a Poisson's ratio of -0.5"},
        Doubtful{
            2,
            "bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4999}}]",
            "Poisson's ratio is 0.4999, and linear elements"},
        Doubtful{2, "bodies: [{density: 1000, elasticity: {model: linear, youngs_modulus: 400, poissons_ratio: 0.4}}]",
                 "the shear modulus at rest is 143 Pa, that of the softest gels"},
        Doubtful{2, "bodies: [{density: 1.08, elasticity: {model: linear, youngs_modulus: 1e7, poissons_ratio: 0.4}}]",
                 "a.yaml:2:10: the density is 1.08 kg/m^3, and solids have 20 (foam) to 22600 (osmium); is 1080 kg/m^3 "
                 "meant, which is 1.08 g/cm^3?"},
        Doubtful{
            2,
            "bodies: [{density: 1080 g/cm^3, elasticity: {model: linear, youngs_modulus: 1e7, poissons_ratio: 0.4}}]",
            "the density is 1.08e+06 kg/m^3, and solids have 20 (foam) to 22600 (osmium); is 1080 kg/m^3 meant"},
        Doubtful{2, "bodies: [{density: 0.001, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0.4}}]",
                 "a number without a unit is in kg/m^3"},
        Doubtful{
            2,
            "bodies: [{volume: a, density: 1.2, rigid: true}, {volume: b, density: 20, elasticity: {model: linear, "
            "youngs_modulus: 1e7, poissons_ratio: 0.4}}]",
            "is 1200 kg/m^3 meant"},
        Doubtful{4, "loads: [{gravity: [0, 0, -9806.65]}]", "if mm/s^2 is meant, write '9806.65 mm/s^2'"},
        Doubtful{3, "constraints: [{surface: clamp, displacement: [0,45, 0]}]",
                 "a.yaml:3:47: '0,45' is read as two entries of the list; if it is one number, write 0.45;"},
        Doubtful{3, "constraints: [{surface: clamp, displacement: [0, 0,45]}]", "'0,45' is read as two entries"},
        Doubtful{4, "loads: [{gravity: [0, -9,81 m/s^2]}]", "if it is one number, write -9.81 m/s^2"},
        Doubtful{5, "time: {method: bdf2, step: 0.01, end: 1, load_steps: 10}",
                 "'load_steps' has an effect only with 'method: static'"},
        Doubtful{6,
                 "contact: {obstacles: [{name: a, shape: plane, normal: [0, 0, 1], motion: {rotate: {axis: [0, 0, 1], "
                 "angle: 90}}}]}",
                 "if degrees are meant, write '90 deg'"},
        Doubtful{6,
                 "joints: [{name: a, type: hinge, between: [ground, a], point: [0, 0, 0], axis: [0, 0, 1], limits: "
                 "[-45, 0]}]",
                 "if degrees are meant, write '-45 deg'"}));

TEST(Advice, BodiesMayBeAtRest) {
  const auto rests = [](const std::string& loads) {
    return nothing_moves(read_input(test::with_line(4, loads), "a.yaml", {}));
  };
  EXPECT_TRUE(rests("loads: []"));
  EXPECT_TRUE(rests("loads: [{gravity: [0, 0, 0]}, {surface: a, spring: 1 kPa/m}]"));
  EXPECT_FALSE(rests("loads: [{surface: a, pressure: t}]"));
  EXPECT_FALSE(rests("initial: {velocity: [0, 0, 1]}"));
  EXPECT_FALSE(rests("cavities: [{name: a, surface: b, gas: {}}]"));
}

TEST(Advice, StaticFormulasOfTimeNeedATime) {
  const std::string ramp =
      "constraints: [{surface: a, displacement: [0, 0, 0]}, {surface: b, displacement: [0, 0, t]}]\n";
  const auto told = [&](const std::string& end) {
    return warnings_of(test::with_line(3, ramp), {{"time", "{method: static" + end + "}"}});
  };
  ASSERT_EQ(told("").size(), 1u);
  EXPECT_NE(told("")[0].find("evaluates formulas of t at 'end', which is 0"), std::string::npos) << told("")[0];
  EXPECT_EQ(told(", end: 2"), std::vector<std::string>{});
}

TEST(Advice, WhatAnAnalysisDoesNotUseIsTold) {
  const auto idle = [](const std::string& method) {
    return texts(
        Severity::note,
        notes_of_idle_keys(read_input(
            test::with_line(
                6,
                "initial: {velocity: [0, 0, 1]}\ncontact: {obstacles: [{name: a, shape: plane, normal: [0, 0, 1], "
                "friction: 0.5}]}"),
            "a.yaml", {{"time.method", method}})));
  };
  EXPECT_EQ(idle("static"), (std::vector<std::string>{
                                "'step' has no effect on a static equilibrium; 'load_steps: 100' applies the loads "
                                "in as many parts",
                                "friction and damping of contact have no effect on a static equilibrium",
                                "the initial state has no effect on a static equilibrium"}));
  EXPECT_EQ(idle("quasistatic"),
            std::vector<std::string>{"the initial velocity has no effect on quasi-static equilibria"});
  EXPECT_EQ(idle("bdf2"), std::vector<std::string>{});
}

TEST(Advice, StepsOfAStaticAnalysisAreToldToBeIdle) {
  const auto idle = [](const std::string& time) {
    return texts(Severity::note,
                 notes_of_idle_keys(read_input(test::with_line(5, "time: {" + time + "}"), "a.yaml", {})));
  };
  const std::vector<std::string> alone{"'step' has no effect on a static equilibrium"};
  EXPECT_EQ(idle("method: static, step: 0.1"),
            std::vector<std::string>{alone[0] + "; 'load_steps: 10' applies the loads in as many parts"});
  EXPECT_EQ(idle("method: static, step: 0.1, end: 1, load_steps: 4"), alone);
  EXPECT_EQ(idle("method: static, step: 0.1, path: {max_load: 3}"), alone);
  EXPECT_EQ(idle("method: static, end: 1, events: [0.5]"),
            std::vector<std::string>{"'events' have no effect on a static equilibrium"});
  EXPECT_EQ(idle("method: static, end: 1"), std::vector<std::string>{});
}

TEST(Advice, AModulusBelowThatOfAnyGelIsWarnedOfWithoutADensityToo) {
  const auto told = [](const std::string& more) {
    return warnings_of(test::with_line(2,
                                       "bodies: [{elasticity: {model: neo-hookean, poissons_ratio: 0.4, "
                                       "youngs_modulus: " +
                                           more + "}]"),
                       {{"time", "{method: static}"}, {"loads", "[]"}});
  };
  ASSERT_EQ(told("0.3}").size(), 1u);
  EXPECT_NE(told("0.3}")[0].find("the shear modulus at rest is 0.11 Pa, less than any gel"), std::string::npos);
  EXPECT_EQ(told("0.3 MPa}"), std::vector<std::string>{});
  EXPECT_EQ(told("3}"), std::vector<std::string>{});
  // Next to nothing is meant.
  EXPECT_EQ(told("1e-9}, viscosity: {model: kelvin-voigt, shear: 100 Pa*s}"), std::vector<std::string>{});
}

TEST(Advice, AgainstLockingIsOneThatTheInputTakes) {
  const auto told = [](const std::string& other) {
    return told_of(2,
                   "bodies: [{volume: a, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, "
                   "poissons_ratio: 0.499}}, {volume: b, density: 1000, elasticity: {model: " +
                       other + ", youngs_modulus: 1e6, poissons_ratio: 0.3}}]");
  };
  ASSERT_EQ(told("neo-hookean").size(), 1u);
  EXPECT_NE(told("neo-hookean")[0].find("use 'volumetric: mixed'"), std::string::npos);
  ASSERT_EQ(told("saint-venant-kirchhoff").size(), 1u);
  EXPECT_NE(told("saint-venant-kirchhoff")[0].find("use 'element: P2' and 'volumetric: mean-dilatation'"),
            std::string::npos);
}

TEST(Advice, WhatLoadsPushAndNothingHoldsMayFall) {
  const auto falls = [](std::size_t line, const std::string& replacement) {
    return may_fall(read_input(test::with_line(line, replacement), "a.yaml", {}));
  };
  EXPECT_TRUE(falls(6, ""));
  EXPECT_FALSE(falls(4, "loads: [{surface: a, pressure: 1 kPa}]"));
  EXPECT_FALSE(falls(4, "loads: [{gravity: [0, 0, -9.81]}, {surface: a, spring: 1 kPa/m}]"));
  EXPECT_FALSE(falls(6, "initial: {velocity: [0, 0, 1]}"));
  EXPECT_FALSE(falls(6, "contact: {obstacles: [{name: a, shape: plane, normal: [0, 0, 1]}]}"));
}

TEST(Advice, NothingIsSaidOfWhatIsUsual) {
  EXPECT_EQ(warnings("step: 0.01, end: 1", ""), std::vector<std::string>{});
  EXPECT_EQ(warnings("step: 0.01, end: 1", "output: {every: 0.01}"), std::vector<std::string>{});
  EXPECT_EQ(warnings("step: 0.3, end: 1", "output: {every: 100 ms, directory: b}", "0.3"), std::vector<std::string>{});
  EXPECT_EQ(warnings("adaptive: {}, step: 0.01, end: 1", "output: {every: 1 ms}"), std::vector<std::string>{});
  EXPECT_EQ(warnings("method: static", "output: {every: 1 ms}"), std::vector<std::string>{});
  EXPECT_EQ(told_of(2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: -0.3}}]"),
            std::vector<std::string>{});
  EXPECT_EQ(told_of(4, "initial: {velocity: [0, 0, 1]}"), std::vector<std::string>{});
  EXPECT_EQ(told_of(3, "constraints: [{surface: a, rigid: {rotation: {axis: [0, 0, 1], angle: 720 deg}}}]"),
            std::vector<std::string>{});
}

}  // namespace
}  // namespace pliant::test_warnings
