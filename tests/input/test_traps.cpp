// What YAML, numbers, units and formulas do that their writer did not mean, or that a hostile writer means.
#include "input/bad_input.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_input_traps {
namespace {

using test::Bad;
using test::mistakes;
using test::processor_time;
using test::told;
using test::with_line;

class Trap : public ::testing::TestWithParam<Bad> {};

TEST_P(Trap, IsToldOnceAtItsPlace) {
  test::expect_told_once(GetParam());
}

// A key that is needed and misspelt is one mistake, not two.
INSTANTIATE_TEST_SUITE_P(
    MisspeltKeysThatAreNeeded, Trap,
    ::testing::Values(
        Bad{1, "@mseh: {file: beam.msh}", "unknown key 'mseh' (did you mean 'mesh'?)"},
        Bad{1, "mesh: {@flie: beam.msh}", "did you mean 'file'?"},
        Bad{2, "@bodeis: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "'bodies'?"},
        Bad{2, "bodies: [{@densty: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "'density'?"},
        Bad{2, "bodies: [{density: 1, @elastisity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "'elasticity'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {@modle: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "'model'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, @youngs_modulos: 1, poissons_ratio: 0}}]",
            "'youngs_modulus'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, @poisson_ratio: 0}}]",
            "'poissons_ratio'?"},
        Bad{3, "constraints: [{@surfase: clamp, displacement: [0, 0, 0]}]", "did you mean 'surface'?"},
        Bad{3, "constraints: [{surface: clamp, @displacment: [0, 0, 0]}]", "did you mean 'displacement'?"},
        Bad{3, "constraints: [{surface: a, displacement_along: 1, @dirction: [0, 0, 1]}]", "did you mean 'direction'?"},
        Bad{3, "constraints: [{surface: a, rigid: {rotation: {axis: [0, 0, 1], @angel: 1}}}]", "'angle'?"},
        Bad{4, "loads: [{@garvity: [0, 0, 1]}]", "did you mean 'gravity'?"},
        Bad{4, "loads: [{surface: tip, @traktion: [0, 0, 1]}]", "did you mean 'traction'?"},
        Bad{4, "loads: [{@surfaces: tip, pressure: 1}]", "did you mean 'surface'?"},
        Bad{5, "time: {@stepp: 0.01, end: 1}", "did you mean 'step'?"},
        Bad{5, "time: {step: 0.01, @ende: 1}", "did you mean 'end'?"},
        Bad{5, "@tiem: {step: 0.01, end: 1}", "did you mean 'time'?"},
        Bad{6, "probes: [{@nmae: a, point: [0, 0, 0]}]", "did you mean 'name'?"},
        Bad{6, "probes: [{name: a, @piont: [0, 0, 0]}]", "did you mean 'point'?"},
        Bad{6, "cavities: [{@nam: a, surface: b, gas: {}}]", "did you mean 'name'?"}));

#define WITH_BODY(more) \
  "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, " more "}]"

INSTANTIATE_TEST_SUITE_P(
    WordsOfOtherPrograms, Trap,
    ::testing::Values(
        Bad{2, WITH_BODY("@damping: 0.1"), "damping of a body is its 'viscosity', as in {model: kelvin-voigt"},
        Bad{2, WITH_BODY("@initial_velocity: [0, 0, 1]"), "'initial: {velocity: [..]}'"},
        Bad{2, WITH_BODY("viscosity: {model: @rayleigh}"),
            "; Rayleigh damping is the sum of mass-proportional and stiffness-proportional"},
        Bad{2, WITH_BODY("viscosity: {model: mass-proportional, decay_rate: 1, @alpha: 1}"),
            "[{model: mass-proportional, decay_rate: alpha}, {model: stiffness-proportional, time: beta}]"},
        Bad{2, WITH_BODY("viscosity: {model: prony, @g: 0.2, relaxation_time: 1}"),
            "is that of its modulus to the one that stays: g of FEBio, and g/(1 - the sum of all g)"},
        Bad{2, WITH_BODY("viscosity: {model: prony, ratio: 0.2, @tau: 1}"), "did you mean 'relaxation_time'?"},
        Bad{6, "@initial_velocity: [0, 0, 1]", "'initial: {velocity: [..]}'"},
        Bad{6, "@boundary_conditions: []", "displacements are prescribed in 'constraints'"},
        Bad{5, "time: {@dt: 0.01, end: 1}", "did you mean 'step'?"},
        Bad{5, "time: {step: 0.01, @duration: 1}", "did you mean 'end'?"},
        Bad{6, "contact: {pairs: all, @mu: 0.3}", "did you mean 'friction'?"},
        Bad{6, "output: {@interval: 0.1}", "did you mean 'every'?"},
        Bad{6, "output: {@format: vtu}", "results are result.xdmf and result.h5"},
        Bad{6, "probes: [{name: a, @coordinates: [0, 0, 0]}]", "did you mean 'point'?"},
        Bad{3, "constraints: [{surface: clamp, @fixed: true}]", "did you mean 'displacement'?"},
        Bad{3, "constraints: [{surface: clamp, displacement: [0, @null, 0]}]",
            "(what is not prescribed is written `free`)"},
        Bad{4, "loads: [{surface: tip, pressure: 1, @follower: true}]", "a 'pressure' follows the surface"},
        Bad{6, "element: @tet10", "of 10 nodes: 'P2'"},
        Bad{6, "solver: {linear: @mumps}", "(a direct solver, MUMPS: 'cholesky')"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: @linear-elastic, youngs_modulus: 1, poissons_ratio: 0}}]",
            "(linear elasticity: 'linear' at small strain"},
        Bad{6, "contact: {obstacles: [{name: a, shape: sphere, radius: 1, @center: [0, 0, 0]}]}",
            "did you mean 'point'?"},
        Bad{4, "loads: [{force: [0, 0, 1], point: @[0, 0, 1]}]",
            "'point' must be the name or tag of a physical group of points (in gmsh: Physical Point), not a place"},
        Bad{6,
            "contact: {obstacles: [{name: a, shape: sphere, radius: 1, motion: {rotate: {axis: [0, 0, 1], angle: "
            "@\"90 degree*t\"}}}]}",
            "where t is the time, and in a unit the tonne: write 1.5707963267948966*t)"},
        Bad{4, "loads: [{surface: a, pressure: @\"2 kPa*sin(t)\"}]", "in a unit the tonne: write 2000*sin(t))"},
        Bad{4, "loads: [{surface: a, pressure: @\"2 kPa*x\"}]", "(formulas are in SI without units: write 2000*x)"}));

#undef WITH_BODY

INSTANTIATE_TEST_SUITE_P(
    DecimalCommas, Trap,
    ::testing::Values(
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0,@45}}]",
            "'45' stands alone after a ','; a decimal point is written '.'"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1,@5 MPa, poissons_ratio: 0}}]",
            "'5 MPa' stands alone after a ','; a decimal point is written '.'"},
        Bad{3, "constraints: [{surface: clamp, displacement: @[0, 0, 0,45]}]",
            "a list of 3 values, not of 4 (a decimal point is written '.': 0.45)"},
        Bad{5, "time: {step: @\"0,01\", end: 1}", "a decimal point is written '.'"},
        Bad{5, "time:\n  end: 1\n  step: @0,01", "a decimal point is written '.'"},
        Bad{4, "loads:\n  - gravity: [0, 0, '-9@,81']", "a decimal point is written '.'"},
        Bad{6, "probes: [{name: a, point: @[0,5, 0,5, 0]}]", "(a decimal point is written '.': 0.5)"}));

INSTANTIATE_TEST_SUITE_P(
    FormulasThatAListSplits, Trap,
    ::testing::Values(
        Bad{3, "constraints: [{surface: clamp, displacement: @[0, min(t, 1), 0]}]",
            "not of 4 (a ',' splits 'min(t'; inside [ ], put a formula in quotes, such as \"min(t, 1)\")"},
        Bad{4, "loads: [{surface: a, traction: @[0, 0, max(0, min(t, 1))]}]", "a ',' splits 'max(0'"}));

TEST(InputTraps, AFormulaThatAMapSplitsIsToldToNeedQuotes) {
  const auto text = told(mistakes(with_line(4, "loads: [{surface: a, pressure: min(t, 1)}]")));
  EXPECT_NE(text.find("a ')' is missing (inside [ ] and { }, put a formula with a ',' in quotes"), std::string::npos)
      << text;
  EXPECT_NE(text.find("'1)' is part of a formula that was split at a ','; inside { }, put the formula in quotes"),
            std::string::npos)
      << text;
}

// As everybody calls them.
INSTANTIATE_TEST_SUITE_P(
    LettersOfElasticConstants, Trap,
    ::testing::Values(
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, @E: 1, poissons_ratio: 0}}]", "'youngs_modulus'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, @nu: 0}}]", "'poissons_ratio'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: neo-hookean, @mu: 1, bulk_modulus: 1}}]", "'shear_modulus'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: neo-hookean, @G: 1, bulk_modulus: 1}}]", "'shear_modulus'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: neo-hookean, shear_modulus: 1, @K: 1}}]", "'bulk_modulus'?"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: neo-hookean, shear_modulus: 1, @lambda: 1}}]",
            "'lame_lambda'?"}));

TEST(InputTraps, OfTheKeysOfElasticityThoseOfTheLawAreListed) {
  const auto keys_of = [](const std::string& law) {
    const std::string text =
        told(mistakes(with_line(2, "bodies: [{density: 1, elasticity: {model: " + law + ", colour: 1}}]")));
    const std::size_t start = text.find("the keys are ");
    return text.substr(start, text.find('\n', start) - start);
  };
  EXPECT_EQ(keys_of("linear"),
            "the keys are model, library, youngs_modulus, poissons_ratio, shear_modulus, bulk_modulus, lame_lambda");
  EXPECT_NE(keys_of("holzapfel-ogden").find("sheet"), std::string::npos);
  EXPECT_EQ(keys_of("holzapfel-ogden").find("youngs_modulus"), std::string::npos);
  EXPECT_NE(keys_of("no-such-law").find("youngs_modulus"), std::string::npos);
}

TEST(InputTraps, MisspeltConstraintsOfAStaticBodyAreOneMistake) {
  const auto found =
      mistakes(with_line(3, "constrains: [{surface: a, displacement: [0, 0, 0]}]"), {{"time.method", "static"}});
  EXPECT_EQ(told(found), "dir/a.yaml:3:1: unknown key 'constrains' (did you mean 'constraints'?)\n");
}

TEST(InputTraps, AMisspeltKeyExcusesNoOtherThatIsMissing) {
  const auto found = mistakes(with_line(5, "time: {stepp: 0.01}"));
  ASSERT_EQ(found.size(), 2u) << told(found);
  EXPECT_NE(found[0].message.find("missing key 'end' in time"), std::string::npos) << told(found);
  const auto of_two = mistakes(
      with_line(2,
                "bodies:\n"
                "  - {volume: a, densty: 1, elasticity: &e {model: linear, youngs_modulus: 1, poissons_ratio: 0}}\n"
                "  - {volume: b, elasticity: *e}"));
  ASSERT_EQ(of_two.size(), 2u) << told(of_two);
  EXPECT_NE(of_two[1].message.find("missing key 'density' in bodies[1]"), std::string::npos) << told(of_two);
}

INSTANTIATE_TEST_SUITE_P(
    Yaml, Trap,
    ::testing::Values(Bad{5, "time: {step: 0.01, end: 1, <<: @3}", "'<<' needs a map of keys, not '3'"},
                      Bad{5, "time: {step: 0.01, <<: [{end: 1}, @end]}", "'<<' needs a map of keys, not 'end'"},
                      Bad{5, "time:\n  step: 0.01\n  end: 1\n @end: 2", "YAML"},
                      Bad{5, "time: {step: 0.01, end: 1}\n@- list", "YAML"},
                      Bad{5, "time: {step: 0.01, end: @!!python/object:os.system 1 s s}", "'1 s s'"},
                      Bad{5, "time: {step: @{0.01}, end: 1}", "'step' must be"},
                      Bad{5, "time: {step: @[0.01], end: 1}", "'step' must be"},
                      Bad{5, "time: {step: 0.01, end: 1, @\"\": 1}", "unknown key ''"},
                      Bad{5, "time: {step: 0.01, end: 1, ? @{a: b} : c}", "a key must be a word, not a map of keys"},
                      Bad{5, "time: {step: 0.01, end: 1, @~: 1}", "a key must be a word, not empty"},
                      Bad{5, "time: {step: 0.01 end@: 1}", "YAML"},
                      Bad{5, "time: &t {step: 0.01, end: @*t}", "this alias refers to a value that contains it"},
                      Bad{1, "mesh: {file: @\"\"}", "'file' must be text, not ''"},
                      Bad{1, "mesh: {file: @!!str}", "'file' must be text, not ''"},
                      Bad{5, "time: @!include time.yaml", "tags such as '!include' are not supported"},
                      Bad{5, "time: @!Time {step: 0.01, end: 1}", "tags such as '!Time' are not supported"},
                      Bad{6, "probes: @!a []", "tags such as '!a' are not supported"},
                      Bad{6, "title: |\n  a\n  b\nelement: @*q", "anchor"},
                      Bad{6, "title: @`x`", "cannot start with this character"},
                      Bad{6, "title: a@\x7F", "control character"}));

INSTANTIATE_TEST_SUITE_P(
    Numbers, Trap,
    ::testing::Values(
        Bad{5, "time: {step: @0x10, end: 100}", "'0x10'"}, Bad{5, "time: {step: @0o10, end: 100}", "'0o10'"},
        Bad{5, "time: {step: @1_000, end: 10000}", "'1_000'"}, Bad{5, "time: {step: @.inf, end: 1}", "'.inf'"},
        Bad{5, "time: {step: @-.INF, end: 1}", "'-.INF'"}, Bad{5, "time: {step: @.NaN, end: 1}", "'.NaN'"},
        Bad{5, "time: {step: @nan, end: 1}", "'nan'"}, Bad{5, "time: {step: @inf, end: 1}", "'inf'"},
        Bad{5, "time: {step: 0.01, end: @1e400}", "'1e400'"},
        Bad{5, "time: {step: @0.01, end: -0}", "longer than the simulation"},
        Bad{5, "time: {step: @0.01, end: 0 s}", "longer than the simulation"},
        Bad{5, "time: {method: bdf2, adaptive: {}, end: @0 ms}", "'end' must be > 0 [s] where steps adapt"},
        Bad{5, "time: {step: 0.01, end: @1e308 year}", "1e308"}, Bad{5, "time: {step: @yes, end: 1}", "'yes'"},
        Bad{5, "time: {step: @true, end: 1}", "'true'"}, Bad{5, "time: {step: @2001-01-01, end: 1}", "2001-01-01"},
        Bad{5, "time: {step: @12:30:45, end: 1}", "12:30:45"}, Bad{5, "time: {step: @1 000, end: 10000}", "1 000"},
        Bad{5, "time: {step: @--1, end: 1}", "'--1'"}, Bad{5, "time: {step: @1e, end: 1}", "'1e'"},
        Bad{5, "time: {step: @\"\", end: 1}", "'step'"}, Bad{5, "time: {step: @\" \", end: 1}", "'step'"},
        Bad{5, "time: {step: @\"0\\t.1\", end: 1}", "'step'"}, Bad{5, "time: {step: @١, end: 10}", "'step'"},
        Bad{1, "mesh: {file: beam.msh, refine: @1e3}", "'refine' must be a whole number"},
        Bad{1, "mesh: {file: beam.msh, refine: @-1}", "'refine' must be a whole number"},
        Bad{1, "mesh: {file: beam.msh, refine: @99999999999999999999}", "'refine' must be a whole number"},
        Bad{1, "mesh: {file: beam.msh, refine: @0x1}", "'refine' must be a whole number"},
        Bad{1, "mesh: {file: beam.msh, scale: @-1}", "'scale' must be > 0"},
        Bad{1, "mesh: {file: beam.msh, scale: @1 mm}", "'scale'"},
        Bad{2, "bodies: [{density: @0, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "'density' must be > 0"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: @-1}}]",
            "'poissons_ratio' must be between"},
        Bad{6, "solver: {newton: {max_iterations: @2147483648}}", "'max_iterations' must be a whole number"},
        Bad{6, "solver: {newton: {absolute: @-1}}", "'absolute' must be"},
        Bad{6, "probes: [{name: a, point: [0, 0, @1e999]}]", "'point[2]'"}));

INSTANTIATE_TEST_SUITE_P(
    Units, Trap,
    ::testing::Values(
        Bad{5, "time: {step: @5 parsecs, end: 1}", "is a length, but a time [s] is expected"},
        Bad{5, "time: {step: @5 furlongs per fortnight, end: 1}", "'step'"},
        Bad{5, "time: {step: @5 s s, end: 1}", "'5 s s'"}, Bad{5, "time: {step: @5 s^, end: 1}", "'5 s^'"},
        Bad{5, "time: {step: @5 s^0, end: 1}", "'5 s^0'"}, Bad{5, "time: {step: @5 s^99999999999, end: 1}", "'step'"},
        Bad{5, "time: {step: @5 (s, end: 1}", "'5 (s'"}, Bad{5, "time: {step: @5 1/0 s, end: 1}", "'step'"},
        Bad{5, "time: {step: @5 since 2001-01-01, end: 1}", "'step'"},
        Bad{5, "time: {step: @5 s since 2001-01-01, end: 1}", "'step'"},
        Bad{5, "time: {step: @5 lg(re s), end: 1}", "'step'"}, Bad{5, "time: {step: @ms, end: 1}", "'step'"},
        Bad{5, "time: {step: @ms 5, end: 1}", "'step'"},
        Bad{2, "bodies: [{density: @1 g, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
            "is a mass"},
        Bad{2, "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: @1 psii, poissons_ratio: 0}}]",
            "psii"},
        Bad{4, "loads: [{surface: tip, traction: [0, 0, @1 N]}]", "is a force, but"},
        Bad{4, "loads: [{surface: tip, pressure: @1 mmHG}]", "1 mmHG"},
        Bad{3, "constraints: [{surface: clamp, displacement: [0, 0, @1 s]}]",
            "is a time, but a length [m] is expected"}));

INSTANTIATE_TEST_SUITE_P(
    Formulas, Trap,
    ::testing::Values(Bad{4, "loads: [{gravity: [0, 0, \"@system(1)\"]}]", "'system'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"@fopen(1)\"]}]", "'fopen'"},
                      Bad{4, "loads: [{gravity: [0, 0, 'sin(\"/etc/passwd\")@']}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"@while(1)\"]}]", "'while'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"t +@= 1\"]}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"t ? 1 : @\"]}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"@t > 1 ? 2\"]}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"2 @$ 3\"]}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"2 *@* t\"]}]", "(a power is written '^')"},
                      Bad{4, "loads: [{gravity: [0, 0, \"(@)\"]}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"sin(@)\"]}]", "'gravity[2]'"},
                      Bad{4, "loads: [{gravity: [0, 0, \"sin(1, 2@)\"]}]", "'sin' has too many arguments"},
                      Bad{4, "loads: [{gravity: [0, 0, @0/0]}]", "'gravity[2]' must be finite"},
                      Bad{4, "loads: [{gravity: [0, 0, @sqrt(-1)]}]", "'gravity[2]' must be finite"},
                      Bad{4, "loads: [{gravity: [0, 0, @1e200*1e200]}]", "'gravity[2]' must be finite"}));

/// Text that is repeated.
std::string times(int n, const std::string& text) {
  std::string result;
  for (int i = 0; i < n; ++i) result += text;
  return result;
}

/// The value is refused, or taken, at once; no message repeats it at length.
void expect_judged_quickly(const std::string& line) {
  const double start = processor_time();
  const auto found = mistakes(with_line(4, line));
  EXPECT_LT(processor_time() - start, 10) << line.substr(0, 60);
  EXPECT_LE(found.size(), 1u) << told(found).substr(0, 2000);
  for (const auto& d : found) EXPECT_LT(d.message.size(), 400u) << d.message;
}

TEST(InputTraps, LongAndDeepFormulasEnd) {
  for (const int n : {10, 300, 3000, 100000}) {
    for (const std::string& formula :
         {times(n, "(") + "t" + times(n, ")"), times(n, "sin(") + "t" + times(n, ")"), times(n, "t+") + "t",
          times(n, "t^") + "t", times(n, "-") + "t", times(n, "t?1:") + "0", times(n, "t?") + "1" + times(n, ":0"),
          times(n, "(1,") + "t" + times(n, ")"), std::string("max(") + times(n, "t,") + "t)", times(n, "t"),
          times(n, "1")}) {
      expect_judged_quickly("loads: [{gravity: [0, 0, \"" + formula + "\"]}]");
    }
  }
}

TEST(InputTraps, LongAndDeepUnitsEnd) {
  for (const int n : {10, 300, 3000, 100000}) {
    for (const std::string& unit : {times(n, "(") + "m" + times(n, ")"), times(n, "m*") + "m", times(n, "m/") + "m",
                                    "m^" + times(n, "9"), times(n, "lg(re ") + "m" + times(n, ")"), times(n, "m"),
                                    times(n, "m "), times(n, "9"), times(n, "1e9 ") + "m", times(n, "k") + "m"}) {
      expect_judged_quickly("loads: [{gravity: [0, 0, \"1 " + unit + "\"]}]");
    }
  }
}

TEST(InputTraps, ManyMisspeltKeysEnd) {
  std::string bodies = "bodies:\n";
  for (int i = 0; i < 4000; ++i) bodies += "  - {volume: v" + std::to_string(i) + ", densty: 1, elastisity: {}}\n";
  const double start = processor_time();
  const auto found = mistakes(with_line(2, bodies));
  EXPECT_EQ(found.size(), 51u);
  EXPECT_LT(processor_time() - start, 10);
}

TEST(InputTraps, BytesThatAreNoTextAreRefusedAtTheirPlace) {
  const std::string nul("title: a\0b", 10);
  EXPECT_EQ(told(mistakes(with_line(6, nul))),
            "dir/a.yaml:6:9: the file contains a control character; is this a text file?\n");
  EXPECT_EQ(told(mistakes(with_line(6, "title: \xC0\xAF"))),
            "dir/a.yaml:6:8: this is not UTF-8 text; is this the right file, saved as UTF-8?\n");
  EXPECT_EQ(told(mistakes(with_line(6, "title: \xED\xA0\x80"))),
            "dir/a.yaml:6:8: this is not UTF-8 text; is this the right file, saved as UTF-8?\n");
}

}  // namespace
}  // namespace pliant::test_input_traps
