// Numbers of an input that are varied, by the table of keys.
#include "base/text.hpp"
#include "input/parse.hpp"
#include "places.hpp"
#include "study/varied_input.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace pliant::test_varied_input {
namespace {

/// Whether a text is a number and a unit, as in `1 MPa`.
bool has_unit(const std::string& text) {
  const std::size_t blank = text.find(' ');
  return blank != std::string::npos && parse_number(std::string_view(text).substr(0, blank)) &&
         text.find_first_of("()*+,") == std::string::npos;
}

/// Keys of numbers with a unit at or below a node for which the table does not know one.
void add_unknown(const InputNode& node, const std::string& path, std::vector<std::string>& keys) {
  if (node.kind == InputNode::Kind::scalar && has_unit(node.text) && unit_of_key(path) == "1") keys.push_back(path);
  for (std::size_t k = 0; k < node.children.size(); ++k) {
    const InputNode& child = node.children[k];
    const std::string part = node.kind == InputNode::Kind::list ? std::to_string(k) : child.key;
    add_unknown(child, path.empty() ? part : path + '.' + part, keys);
  }
}

TEST(VariedInput, KnowsTheUnitsOfKeys) {
  EXPECT_EQ(unit_of_key("bodies.0.elasticity.youngs_modulus"), "Pa");
  EXPECT_EQ(unit_of_key("loads.push.traction.2"), "Pa");
  EXPECT_EQ(unit_of_key("springs.0.points.1.2"), "m");
  EXPECT_EQ(unit_of_key("tendons.cord.points.0.0"), "m");
  EXPECT_EQ(unit_of_key("constraints.0.box.1.0"), "m");
  EXPECT_EQ(unit_of_key("contact.obstacles.0.normal.2"), "1");
  EXPECT_EQ(unit_of_key("bodies.0.elasticity.poissons_ratio"), "1");
}

TEST(VariedInput, KnowsTheUnitsOfAllThatInputsGiveOne) {
  const std::filesystem::path inputs = source_root() / "input";
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(inputs)) {
    if (entry.path().extension() != ".yaml" || entry.path().parent_path().filename() == "fit") continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    Diagnostics ignored;
    std::vector<std::string> keys;
    add_unknown(parse_yaml(text.str(), entry.path(), ignored), "", keys);
    EXPECT_EQ(joined(keys), "") << entry.path();
    ++count;
  }
  EXPECT_GT(count, 30);
}

}  // namespace
}  // namespace pliant::test_varied_input
