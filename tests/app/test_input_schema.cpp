// The JSON schema and the reference tell of every key of the table.
#include "app/input.hpp"
#include "app/input_schema.hpp"
#include "petsc/session.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

namespace pliant {
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
  Json node = Json::parse(json_schema());
  for (const auto& parent : parents) {
    node = node.at("properties").at(parent);
    if (node.contains("items")) node = node.at("items");
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
  std::ifstream stream(std::string(PLIANT_SOURCE_DIR) + "/docs/input.md");
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

/// Python's jsonschema as the referee: what is good for the reader is good for the schema, and typical mistakes are
/// not.
TEST(JsonSchema, JudgesLikeTheReader) {
  if (rank(MPI_COMM_WORLD) != 0) return;
  const std::string python = "/usr/bin/python3";
  if (std::system((python + " -c 'import jsonschema, yaml' 2> /dev/null").c_str()) != 0) {
    FAIL() << "python3-jsonschema or python3-yaml is missing";
  }
  const std::string base = testing::TempDir() + "pliant_schema_" + std::to_string(getpid());
  std::ofstream(base + ".json") << json_schema();
  std::ofstream(base + ".py") << R"yaml(
import json, sys, jsonschema, yaml
schema = json.load(open(sys.argv[1]))
jsonschema.Draft7Validator.check_schema(schema)
jsonschema.validate(yaml.safe_load(open(sys.argv[2])), schema)
)yaml";
  const std::string good = R"yaml(
mesh: {file: beam.msh, size: 20 mm}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1.0e+6, poissons_ratio: 0.4}}]
constraints: [{surface: clamp, displacement: [0, free, "t"]}, {box: [[0, 0, 0], [1, 1, 1]], displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}, {surface: 3, traction: [0, 0, 1 kPa]}]
time: {step: 10 ms, end: 1}
)yaml";
  const auto accepted = [&](const std::string& text) {
    std::ofstream(base + ".yaml") << text;
    const std::string arguments = " " + base + ".py " + base + ".json " + base + ".yaml > " + base + ".out 2>&1";
    return std::system((python + arguments).c_str()) == 0;
  };
  EXPECT_TRUE(accepted(good));
  EXPECT_TRUE(accepted(dump(read_input(good, "a.yaml", {}))));
  for (const std::string bad :
       {"contact: 1", "loads: [{gravity: [0, 0, 1], surface: a}]", "loads: [{traction: [0, 0, 1]}]",
        "loads: [{surface: a}]", "element: P3", "mesh: {size: 1}", "mesh: {file: a, scale: 0}",
        "constraints: [{displacement: [0, 0, 0]}]", "constraints: [{surface: a, curve: b, displacement: [0, 0, 0]}]"}) {
    const std::string key = bad.substr(0, bad.find(':') + 1);
    std::string text = good;
    if (const std::size_t at = text.find("\n" + key); at != std::string::npos) {
      text.erase(at, text.find('\n', at + 1) - at);
    }
    EXPECT_FALSE(accepted(text + bad + '\n')) << bad;
    EXPECT_THROW(read_input(text + bad + '\n', "a.yaml", {}), InputError) << bad;
  }
  for (const char* end : {".json", ".py", ".yaml", ".out"}) std::filesystem::remove(base + end);
}

}  // namespace
}  // namespace pliant
