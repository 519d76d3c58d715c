// What is written of an input: every key, and the same after reading it again.
#include "input/analysis.hpp"
#include "input/examples.hpp"
#include "input/keys.hpp"
#include "input/loads.hpp"
#include "input/parse.hpp"
#include "material/elastic_law.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_input {
namespace {

namespace fs = std::filesystem;

/// Every path of keys that a tree gives.
void collect_paths(const InputNode& node, const std::string& path, std::vector<std::string>& paths) {
  for (const InputNode& child : node.children) {
    const std::string own = child.key.empty() ? path : path.empty() ? child.key : path + "." + child.key;
    paths.push_back(own);
    collect_paths(child, own, paths);
  }
}

void collect_paths(const std::vector<KeyInfo>& keys, const std::string& path, std::vector<std::string>& paths) {
  for (const KeyInfo& key : keys) {
    const std::string own = path.empty() ? key.key : path + "." + key.key;
    paths.push_back(own);
    collect_paths(key.children, own, paths);
  }
}

TEST(Dump, SpellsOutEveryKeyOfTheTable) {
  std::vector<std::string> expected, written;
  collect_paths(input_keys(), "", expected);
  Diagnostics none;
  collect_paths(parse_yaml(dump(read(everything)), "dump", none), "", written);
  for (const std::string part : {"box: [[0, 0, 0], [1, 1, 1]]", "where: \"z < 0.1\""}) {
    const std::string contact = "{" + part + ", obstacles: [{name: ball, shape: sphere, radius: 1}]}";
    collect_paths(parse_yaml(dump(read(smallest, {{"contact", contact}})), "dump", none), "", written);
  }
  const std::string between =
      "{law: barrier, friction: 0.1, viscous_friction: 1, normal_damping: 2, pairs: [{name: grip, surface: a, with: b, "
      "law: penalty, stiffness: 1, width: 1, thickness: 1, friction: 0.5, viscous_friction: 0, normal_damping: 0}], "
      "exclude: [[c, "
      "d]]}";
  collect_paths(parse_yaml(dump(read(smallest, {{"contact", between}})), "dump", none), "", written);
  for (const std::string& time : other_times) {
    collect_paths(parse_yaml(dump(read(everything, {{"time", time}})), "dump", none), "", written);
  }
  collect_paths(parse_yaml(dump(read(everything, {{"bodies",
                                                   "[{density: 1, elasticity: {model: neo-hookean, youngs_modulus: 1, "
                                                   "poissons_ratio: 0}, viscosity: {model: prony, ratio: 0.3, "
                                                   "relaxation_time: 1}, mullins: {r: 2, m: 1, beta: 0.1}}]"}})),
                           "dump", none),
                "", written);
  const std::vector<Override> mechanism{
      {"mesh.refine", "0"},
      {"rigid_bodies",
       "[{name: r, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0], velocity: [1, 0, 0], angular_velocity: "
       "[0, 0, 1], surface: {file: r.stl, scale: 1, size: 1}, attached: [a], coupled: [b], coupling_stiffness: 1}]"},
      {"bodies", "[{volume: v, density: 1, rigid: true, attached: [a], coupled: [b], coupling_stiffness: 1}]"},
      {"loads", "[{torque: [t, 0, 0], volume: r}]"},
      {"joints",
       "[{name: j, type: hinge, between: [ground, r], point: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 1, "
       "rest: 1}, damping: 1, motor: {target: t, stiffness: 1, damping: 1, limit: 1, effort: t}, limits: [-1, 1], "
       "limit_stiffness: 1, friction: 1, bearing: {friction: 1, radius: 1, length: 1}, stick_rate: 1}, {name: k, type: "
       "universal, between: [ground, r], point: [0, 0, 0], axis: [0, 0, 1], second_axis: [1, 0, 0]}, {name: l, "
       "type: distance, between: [ground, r], point: [0, 0, 0], second_point: [1, 0, 0], motion: t}]"},
      {"tendons",
       "[{name: s, points: [[0, 0, 0], {body: r, point: [1, 0, 0]}], tension: t}, {name: u, curve: c, pulled_at: "
       "[0, 0, 0], pull: t, stiffness: 1, friction: 0.1, stick_velocity: 1}]"},
      {"springs",
       "[{name: d, points: [[0, 0, 0], {body: r, point: [1, 0, 0]}], stiffness: 1, rest: 1, damping: 1, "
       "tension_only: false}]"},
      {"rods",
       "[{name: p, points: [[0, 0, 0], [1, 0, 0]], segments: 2, radius: 1, density: 1, youngs_modulus: 1, "
       "poissons_ratio: 0, damping: 1, start: ground, end: r}, {name: w, points: [[0, 0, 0], [1, 0, 0]], size: 1, "
       "section: {width: "
       "1, height: 1, up: [0, 0, 1], torsion_constant: 1}, density: 1, youngs_modulus: 1, poissons_ratio: 0}, {name: "
       "x, "
       "curve: c, radius: 1, bending: true, density: 1, youngs_modulus: 1, poissons_ratio: 0}]"},
      {"shells",
       "[{name: s, surface: a, thickness: 1, density: 1, prestretch: [1, 1.1], direction: [1, 0, 0], damping: 1, "
       "viscosity: [{model: kelvin-voigt, shear: 1, bulk: 1}, {model: stiffness-proportional, time: 1}], "
       "bending: true, free: true, clamped: [{curve: c, normal: [1, 0, 0]}], elasticity: {model: linear, "
       "youngs_modulus: 1, poissons_ratio: 0}}, {name: t, box: [[0, 0, 0], "
       "[1, 1, 1]], thickness: 1, elasticity: {library: ecoflex-00-30}}, {name: u, where: \"z < 0.1\", thickness: 1, "
       "prestretch: 1.1, elasticity: {model: linear, youngs_modulus: x, poissons_ratio: 0}}]"}};
  collect_paths(parse_yaml(dump(read(everything, mechanism)), "dump", none), "", written);
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    const ElasticLawSpec law = typical_law(row);
    std::string model = "elasticity: {model: " + std::string(law.info().name);
    for (std::size_t p = 0; p < law.parameters.size(); ++p) {
      model += fmt::format(", {}: {}", law.info().parameters[p].name, law.parameters[p]);
    }
    for (std::size_t d = 0; d < law.info().directions.size(); ++d) {
      model += fmt::format(", {}: [x, {}, 0]", law.info().directions[d], d);
    }
    const std::string body = "[{density: 1, " + model + "}}]",
                      shell = "[{name: s, surface: a, thickness: 1, " + model + "}}]";
    collect_paths(parse_yaml(dump(read(everything, {{"bodies", body}, {"shells", shell}})), "dump", none), "", written);
  }
  collect_paths(
      parse_yaml(dump(read(smallest, {{"bodies", "[{elasticity: {library: ecoflex-00-30}}]"}})), "dump", none), "",
      written);
  for (const char* active : {"{stress: 20 kPa, fibre: {cell_data: f}}", "{shortening: 0.1*t, fibre: [1, y, 0]}"}) {
    const std::string body =
        "[{density: 1, elasticity: {model: linear, youngs_modulus: {cell_data: \"the E\"}, "
        "poissons_ratio: 0}, active: ";
    collect_paths(parse_yaml(dump(read(everything, {{"bodies", body + active + "}]"}})), "dump", none), "", written);
  }
  collect_paths(parse_yaml(dump(read(smallest, {{"bodies",
                                                 "[{density: 1, elasticity: {model: linear, youngs_modulus: 1, "
                                                 "poissons_ratio: 0}, expansion: {stretch: 1+0.1*t}}]"}})),
                           "dump", none),
                "", written);
  const std::vector<Override> path_of_equilibria{
      {"constraints", "[{surface: a, displacement: [0, 0, 0]}]"},
      {"time",
       "{method: static, path: {by: arc-length, max_load: 3, min_load: -1, max_step: 2, max_steps: 9, stop: [{column: "
       "step, above: 1, below: -1}]}}"}};
  collect_paths(parse_yaml(dump(read(smallest, path_of_equilibria)), "dump", none), "", written);
  for (const auto& path : expected) {
    EXPECT_NE(std::find(written.begin(), written.end(), path), written.end()) << path << " is not written";
  }
}

class RoundTrip : public testing::TestWithParam<std::string> {};

TEST_P(RoundTrip, KeepsTheConfiguration) {
  const Config original = read(GetParam());
  const std::string text = dump(original);
  const Config again = read_input(text, "quite/elsewhere/run.yaml", {});
  EXPECT_EQ(dump(again), text);
  EXPECT_EQ(again.output.directory, original.output.directory);
  EXPECT_TRUE(fs::path(again.mesh.file.value).is_absolute());
  ASSERT_EQ(again.constraints.size(), original.constraints.size());
  for (std::size_t i = 0; i < again.constraints.size(); ++i) {
    EXPECT_EQ(again.constraints[i].part.kind, original.constraints[i].part.kind);
    EXPECT_EQ(again.constraints[i].part.name, original.constraints[i].part.name);
    EXPECT_EQ(again.constraints[i].part.box, original.constraints[i].part.box);
    ASSERT_EQ(again.constraints[i].kind.index(), original.constraints[i].kind.index());
    const auto* a = std::get_if<ConstraintConfig::Displacement>(&again.constraints[i].kind);
    const auto* b = std::get_if<ConstraintConfig::Displacement>(&original.constraints[i].kind);
    for (std::size_t k = 0; a != nullptr && k < 3; ++k) {
      ASSERT_EQ(a->value[k].has_value(), b->value[k].has_value());
      if (a->value[k]) {
        EXPECT_EQ((*a->value[k])(0.1, 0.2, 0.3, 0.4), (*b->value[k])(0.1, 0.2, 0.3, 0.4));
      }
    }
  }
  ASSERT_EQ(again.loads.size(), original.loads.size());
  for (std::size_t i = 0; i < again.loads.size(); ++i) {
    const LoadConfig &a = again.loads[i], &b = original.loads[i];
    ASSERT_EQ(a.kind.index(), b.kind.index());
    EXPECT_EQ(a.part.kind, b.part.kind);
    if (const VectorExpression* value = vector_of(a)) {
      EXPECT_EQ((*value)[2](0.1, 0.2, 0.3, 0.4), (*vector_of(b))[2](0.1, 0.2, 0.3, 0.4));
    }
    if (const auto* pressure = std::get_if<LoadConfig::Pressure>(&a.kind)) {
      EXPECT_EQ(pressure->value(0.1, 0.2, 0.3, 0.4), std::get<LoadConfig::Pressure>(b.kind).value(0.1, 0.2, 0.3, 0.4));
    }
    if (const auto foundation = foundation_of(a)) {
      EXPECT_EQ(foundation->spring, foundation_of(b)->spring);
      EXPECT_EQ(foundation->dashpot, foundation_of(b)->dashpot);
    }
    if (const auto* foundation = std::get_if<LoadConfig::Foundation>(&a.kind)) {
      EXPECT_EQ(foundation->direction, std::get<LoadConfig::Foundation>(b.kind).direction);
    }
  }
  EXPECT_EQ(again.time.step, original.time.step);
  EXPECT_EQ(again.time.min_step, original.time.min_step);
}

INSTANTIATE_TEST_SUITE_P(Inputs, RoundTrip,
                         testing::Values(smallest, everything,
                                         smallest + "title: \"line\\none\\ttab \\\\ caf\u00e9\"\n",
                                         "mesh: {file: a.msh}\nbodies: [{elasticity: {library: ecoflex-00-30, c10: 9 "
                                         "kPa}}]\ntime: {step: 10 ms, end: 1}\n",
                                         smallest + "constraints: [{surface: \"null\", displacement: [0, 0, 0]}]\n",
                                         smallest + "constraints: [{surface: \"~\", displacement: [0, 0, 0]}]\n",
                                         smallest +
                                             "constraints: [{surface: \"a: b # c\", displacement: [0, 0, 1e-17]}]\n",
                                         R"yaml(
mesh: {file: /absolute/beam.msh}
bodies: [{elasticity: {model: linear, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
constraints: [{surface: 1, displacement: [0, 0, 0]}]
time: {method: static, load_steps: 4, path: {min_load: -2, stop: [{column: step, above: 3}]}}
)yaml"));

TEST(Input, TimesOfAllKindsKeepThroughWritingAndReading) {
  for (const std::string& time : other_times) {
    const Config original = read(everything, {{"time", time}});
    const Config again = read_input(dump(original), "run.yaml", {});
    EXPECT_EQ(dump(again), dump(original)) << time;
    EXPECT_EQ(method_name(again.time.method), method_name(original.time.method));
    EXPECT_EQ(again.time.step, original.time.step);
    EXPECT_EQ(again.time.min_step, original.time.min_step);
    EXPECT_EQ(again.time.startup, original.time.startup);
    EXPECT_EQ(again.time.events, original.time.events);
    ASSERT_EQ(again.time.adaptive.has_value(), original.time.adaptive.has_value());
    if (again.time.adaptive) {
      const AdaptiveConfig &a = *again.time.adaptive, &b = *original.time.adaptive;
      EXPECT_EQ(std::tie(a.relative, a.absolute, a.absolute_velocity, a.min_step, a.max_step),
                std::tie(b.relative, b.absolute, b.absolute_velocity, b.min_step, b.max_step));
    }
    ASSERT_EQ(again.time.method.kind.index(), original.time.method.kind.index());
    if (method_of(again.time) != nullptr) {
      const Method &a = *method_of(again.time), &b = *method_of(original.time);
      EXPECT_EQ(std::tie(a.alpha, a.beta, a.A, a.b), std::tie(b.alpha, b.beta, b.A, b.b)) << "to the last bit";
    }
  }
}

}  // namespace
}  // namespace pliant::test_input
