// The JSON schema and the reference tell of every key of the table.
#include "input/input.hpp"
#include "input/keys.hpp"
#include "input/reference.hpp"
#include "petsc/session.hpp"
#include "places.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_input_schema {
namespace {

struct TableKey {
  std::string path;
  KeyInfo info;
  std::vector<std::string> parents;
};

void PrintTo(const TableKey& key, std::ostream* out) {
  *out << key.path;
}

void collect(const std::vector<KeyInfo>& keys, const std::vector<std::string>& parents, std::vector<TableKey>& all) {
  for (const KeyInfo& key : keys) {
    std::string path;
    for (const auto& parent : parents) path += parent + ".";
    all.push_back({path + key.key, key, parents});
    std::vector<std::string> deeper = parents;
    deeper.push_back(key.key);
    collect(key.children, deeper, all);
  }
}

std::vector<TableKey> all_keys() {
  std::vector<TableKey> all;
  collect(input_keys(), {}, all);
  return all;
}

class EveryKey : public testing::TestWithParam<TableKey> {};

TEST_P(EveryKey, IsDescribed) {
  const KeyInfo& key = GetParam().info;
  EXPECT_GE(key.description.size(), 8u);
  EXPECT_FALSE(key.type.empty());
  EXPECT_TRUE(key.need == KeyInfo::Need::optional || (key.fallback.empty() && key.fallback_words.empty()))
      << "a required key has no default";
}

TEST_P(EveryKey, StandsInTheReference) {
  const auto& [path, key, parents] = GetParam();
  const std::string reference = input_reference();
  const std::string row = key.children.empty() ? "\n| `" + key.key + "` | " : "\n| [`" + key.key + "`](#";
  const std::size_t at = reference.find(row);
  ASSERT_NE(at, std::string::npos);
  EXPECT_NE(reference.find(key.description), std::string::npos);
}

TEST_P(EveryKey, StandsInTheJsonSchema) {
  const auto& [path, key, parents] = GetParam();
  auto node = nlohmann::ordered_json::parse(json_schema());
  for (const auto& parent : parents) {
    node = node.at("properties").at(parent);
    if (node.contains("anyOf")) node = node.at("anyOf").back();  // names first, keys after them; one, then a list
    if (node.contains("items")) node = node.at("items");
    if (node.contains("anyOf")) node = node.at("anyOf").back();  // an entry that is a list or keys
  }
  ASSERT_TRUE(node.at("properties").contains(key.key));
  EXPECT_EQ(node["properties"][key.key].at("description"), key.description);
  EXPECT_EQ(node.at("additionalProperties"), false);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryKey, testing::ValuesIn(all_keys()), [](const auto& param_info) {
  std::string name = param_info.param.path;
  for (char& c : name) c = c == '.' ? '_' : c;
  return name;
});

TEST(InputReference, IsUpToDate) {
  std::ifstream stream(source_root() / "docs/input.md");
  const std::string written{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_TRUE(written == input_reference())
      << "docs/input.md is stale; write it anew: build/bin/pliant schema --markdown > docs/input.md";
}

/// The example in the reference is what users copy first.
TEST(InputReference, HasAGoodExample) {
  const std::string reference = input_reference();
  const std::string fence = "```yaml\n";
  const std::size_t start = reference.find(fence) + fence.size();
  const std::string example = reference.substr(start, reference.find("```", start) - start);
  EXPECT_NO_THROW(read_input(example, "input/a.yaml", {})) << example;
}

/// A good input with one line replaced or added.
std::string with_line(const std::string& line) {
  std::string text = R"yaml(
mesh: {file: beam.msh, size: 20 mm}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1.0e+6, poissons_ratio: 0.4}}]
constraints: [{surface: clamp, displacement: [0, free, "t"]}, {box: [[0, 0, 0], [1, 1, 1]], displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}, {surface: 3, traction: [0, 0, 1 kPa]}]
time: {step: 10 ms, end: 1}
)yaml";
  if (const std::size_t at = text.find("\n" + line.substr(0, line.find(':') + 1)); at != std::string::npos) {
    text.erase(at, text.find('\n', at + 1) - at);
  }
  return text + line + '\n';
}

std::string viscous(const std::string& viscosity) {
  return "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}, viscosity: " +
         viscosity + "}]";
}

const std::vector<std::string> good_lines{
    "title: good",
    "loads: [{surface: a, pressure: 2 kPa}, {where: x, pressure: \"t\"}, {gravity: [0, 0, 1], volume: a}]",
    "loads: [{surface: a, spring: 1e5 Pa/m, dashpot: 3, direction: normal}, {where: x, dashpot: 2 Pa*s/m}, {point: p, "
    "point_spring: 2 N/m, point_dashpot: 1}]",
    "cavities: [{name: a, surface: b, gas: {}}, {name: c, where: x, liquid: {added_volume: t}}]",
    "cavities: [{name: a, surface: b, volume: 1, pressure: 2 kPa}]",
    "contact: {law: barrier, stiffness: 1 MPa/m, width: 1 mm, threshold: 0, friction_update: iterated, stick_velocity: "
    "1 "
    "cm/s, obstacles: [{name: a, shape: plane, normal: [0, 0, 2], friction: 0.5, viscous_friction: 1, normal_damping: "
    "0.1 "
    "s/m}]}",
    "contact: {law: barrier, pairs: all, exclude: [[a, b], [c, 3]]}",
    "contact: {pairs: all, start: resolve}",
    "contact: {pairs: [{surface: a, with: b, law: barrier}, {surface: c, with: d, law: penalty, thickness: 1 mm}]}",
    "contact: {law: barrier, pairs: [{surface: a, with: b, stiffness: 1 MPa/m, width: 1 mm, thickness: 0}, {surface: "
    "c}]}",
    "contact: {obstacles: [{name: a, shape: sphere, radius: 1, side: inside, motion: {translate: [\"t\", 0, 0]}}, "
    "{name: "
    "b, shape: cylinder, axis: [1, 0, 0], radius: 1 mm, length: 1, motion: {rotate: {axis: [0, 0, 1], angle: t}}}, "
    "{name: "
    "c, shape: capsule, axis: [1, 0, 0], radius: 1, length: 2, point: [0, 1, 0]}, {name: d, shape: box, size: [1, 1, "
    "1], "
    "motion: {rotate: {axis: [0, 0, 1], angle: 30 degree, center: [0, 0, 0]}}}, {name: e, shape: surface, file: a.stl, "
    "scale: 0.001}]}",
    "loads: [{force_density: [0, 0, 1 N/m^3]}, {curve: c, line_force: [0, t, 1]}, {point: p, force: [0, 1 N, 0]}, "
    "{surface: s, force: [1, 1, 1]}, {volume: v, force_density: [1, 0, 0]}]",
    "constraints: [{surface: a, symmetry: plane}, {where: x, normal_displacement: \"t\"}, {point: a, "
    "displacement_along: 1, direction: [1, 0, 0]}, {surface: a, periodic_with: b, difference: [free, 0, 0]}, "
    "{surface: a, tied_to: b, tolerance: 1 mm}]",
    "constraints: [{surface: a, rigid: {}}, {point: a, rigid: {translation: [0, free, \"t\"], rotation: {axis: [0, 0, "
    "1], angle: 90 degree}}}, {equation: [{point: a, component: x}, {point: b, component: y, coefficient: 2}]}]",
    viscous("{model: kelvin-voigt, shear: 20 Pa*s}"),
    viscous("{model: kelvin-voigt, shear: 0, bulk: 1, rate: reconstructed}"),
    viscous("{model: maxwell, shear_modulus: 1, relaxation_time: 1, bulk_modulus: 1}"),
    viscous("[{model: maxwell, shear_ratio: 1, relaxation_time: 1, bulk_ratio: 10 %}, {model: mass-proportional, "
            "decay_rate: 1 Hz}]"),
    viscous("{model: stiffness-proportional, time: 1 ms, rate: auto}"),
    viscous("[{model: prony, ratio: 0.3, relaxation_time: 1}, {model: prony, ratio: 30 %, relaxation_time: 1 min}]"),
    "time: {method: symplectic-dirk22, step: 1 ms, end: 1, events: [0.1, 200 ms]}",
    "time: {method: bdf3, end: 1 s, startup: ramp, adaptive: {}}",
    "time: {method: dirk22, end: 1, adaptive: {relative: 1.0e-3, absolute: 1 um, absolute_velocity: 1 mm/s, min_step: "
    "1 "
    "us, max_step: 0.1}}",
    "time: {method: \"petsc:alpha2\", step: 1 ms, end: 1}",
    "time: {method: {petsc: bdf}, step: 1 ms, end: 1}",
    "time: {method: {A: [[1]], b: [1], alpha: [4/3, -1/3], beta: 2/3, name: mine}, step: 1 ms, end: 1}",
};

const std::vector<std::string> bad_lines{
    "contact: 1",
    "contact: {}",
    "contact: {law: barrier, pairs: [{surface: a, law: wall}]}",
    "contact: {law: barrier, pairs: none}",
    "contact: {law: barrier, pairs: []}",
    "contact: {law: barrier, pairs: [{with: a}]}",
    "contact: {law: barrier, pairs: all, exclude: [[a]]}",
    "contact: {law: barrier, exclude: [[a, b]], obstacles: [{name: a, shape: sphere, radius: 1}]}",
    "contact: {obstacles: []}",
    "contact: {obstacles: [{shape: sphere, radius: 1}]}",
    "contact: {obstacles: [{name: a, shape: sphere}]}",
    "contact: {obstacles: [{name: a, shape: sphere, radius: 1, normal: [0, 0, 1]}]}",
    "contact: {obstacles: [{name: a, shape: plane, normal: [0, 0, 1], radius: 1}]}",
    "contact: {law: spring, obstacles: [{name: a, shape: sphere, radius: 1}]}",
    "contact: {obstacles: [{name: a, shape: sphere, radius: 1, friction: -1}]}",
    "contact: {obstacles: [{name: a, shape: sphere, radius: 1, motion: {rotate: {angle: 1}}}]}",
    "loads: [{gravity: [0, 0, 1], surface: a}]",
    "loads: [{gravity: [0, 0, 1], volume: a, where: x}]",
    "loads: [{traction: [0, 0, 1]}]",
    "loads: [{surface: a}]",
    "loads: [{pressure: 1}]",
    "cavities: [{name: a, surface: b}]",
    "cavities: [{surface: b, gas: {}}]",
    "cavities: [{name: a, surface: b, gas: {}, liquid: {}}]",
    "cavities: [{name: a, surface: b, gas: {exponent: 0}}]",
    "loads: [{spring: 1}]",
    "loads: [{spring: 1, point_spring: 1, surface: a}]",
    "loads: [{spring: 1, surface: a, point: p}]",
    "loads: [{point_dashpot: 1, surface: a}]",
    "loads: [{surface: a, pressure: 1, direction: all}]",
    "loads: [{force: [0, 0, 1]}]",
    "loads: [{force: [0, 0, 1], curve: a, point: b}]",
    "loads: [{line_force: [0, 0, 1], surface: a}]",
    "loads: [{surface: a, box: [[0, 0, 0], [1, 1, 1]], pressure: 1}]",
    "loads: [{surface: a, traction: [0, 0, 1], pressure: 1}]",
    viscous("{shear: 1}"),
    viscous("{model: kelvin-voigt}"),
    viscous("{model: kelvin-voigt, shear: -1}"),
    viscous("{model: kelvin-voigt, shear: 1, rate: best}"),
    viscous("{model: kelvin-voigt, shear: 1, relaxation_time: 1}"),
    viscous("{model: maxwell, shear_modulus: 1}"),
    viscous("{model: maxwell, shear_modulus: 1, relaxation_time: 1, bulk: 1}"),
    viscous("{model: maxwell, shear_modulus: 1, shear_ratio: 1, relaxation_time: 1}"),
    viscous("[]"),
    "element: P3",
    "mesh: {size: 1}",
    "mesh: {file: a, scale: 0}",
    "constraints: [{displacement: [0, 0, 0]}]",
    "constraints: [{surface: a, curve: b, displacement: [0, 0, 0]}]",
    "constraints: [{surface: a}]",
    "constraints: [{surface: a, symmetry: true}]",
    "constraints: [{surface: a, displacement_along: 1}]",
    "constraints: [{surface: a, symmetry: plane, difference: [0, 0, 0]}]",
    "constraints: [{surface: a, rigid: {rotation: {axis: [0, 0, 1]}}}]",
    "constraints: [{surface: a, equation: [{point: a, component: x}]}]",
    "time: {method: bdf4, step: 1, end: 1}",
    "time: {method: {petsc: rk}, step: 1, end: 1}",
    "time: {method: {A: [[1]]}, step: 1, end: 1}",
    "time: {method: {petsc: bdf, b: [1]}, step: 1, end: 1}",
    "time: {method: {}, step: 1, end: 1}",
    "time: {step: 1, end: 1, adaptive: true}",
    "time: {step: 1, end: 1, adaptive: {relative: 0}}",
    "time: {step: 1, end: 1, events: [0]}",
    "time: {step: 1, end: 1, startup: bdf2}",
};

/// Python's jsonschema as the referee: for each text, '1' if it fits the schema.
std::string verdicts(const std::vector<std::string>& texts) {
  const std::string base = testing::TempDir() + "pliant_schema_" + std::to_string(getpid());
  std::ofstream(base + ".json") << json_schema();
  std::ofstream(base + ".py") << R"py(
import json, sys, jsonschema, yaml
base = sys.argv[1]
schema = json.load(open(base + ".json"))
jsonschema.Draft7Validator.check_schema(schema)
judge = jsonschema.Draft7Validator(schema)
texts = open(base + ".yaml").read().split("\n---\n")
open(base + ".out", "w").write("".join("01"[judge.is_valid(yaml.safe_load(text))] for text in texts))
)py";
  std::ofstream all(base + ".yaml");
  for (std::size_t i = 0; i < texts.size(); ++i) all << (i > 0 ? "\n---\n" : "") << texts[i];
  all.close();
  const int failed = std::system(("/usr/bin/python3 " + base + ".py " + base).c_str());
  EXPECT_EQ(failed, 0) << "are python3-jsonschema and python3-yaml installed?";
  std::ifstream out(base + ".out");
  std::string result{std::istreambuf_iterator<char>(out), {}};
  for (const char* end : {".json", ".py", ".yaml", ".out"}) std::filesystem::remove(base + end);
  return result;
}

/// What is good for the reader is good for the schema, as given and as written again; typical mistakes are not.
TEST(JsonSchema, JudgesLikeTheReader) {
  if (rank(MPI_COMM_WORLD) != 0) return;
  std::vector<std::string> texts;
  std::string expected;
  for (const std::string& line : good_lines) {
    texts.push_back(with_line(line));
    texts.push_back(dump(read_input(with_line(line), "a.yaml", {})));
    expected += "11";
  }
  for (const std::string& line : bad_lines) {
    texts.push_back(with_line(line));
    expected += '0';
    EXPECT_THROW(read_input(texts.back(), "a.yaml", {}), InputError) << line;
  }
  const std::string judged = verdicts(texts);
  ASSERT_EQ(judged.size(), expected.size());
  for (std::size_t i = 0; i < texts.size(); ++i) EXPECT_EQ(judged[i], expected[i]) << texts[i];
}

}  // namespace
}  // namespace pliant::test_input_schema
