// What `pliant methods` and `pliant materials` tell comes from their tables.
#include "command/commands.hpp"
#include "command/material_reference.hpp"
#include "places.hpp"
#include "time/method.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_commands {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

TEST(MethodsText, HasARowForEveryMethodWithItsNumbers) {
  const auto lines = lines_of(methods_text());
  for (const Method& m : methods()) {
    const auto line = std::ranges::find_if(lines, [&](const auto& l) { return l.starts_with(m.name + " "); });
    ASSERT_NE(line, lines.end()) << m.name;
    auto words = words_of(*line);
    EXPECT_EQ(words.at(1), std::to_string(m.order));
    if (m.name == "bdf3") {
      EXPECT_EQ(words.at(2), "(2)") << "after the ramp";
      words.erase(words.begin() + 2);
    }
    EXPECT_EQ(words.at(2), std::to_string(m.num_stages));
    EXPECT_NE(line->find("  " + to_string(m.stability) + "  "), std::string::npos) << *line;
    const auto tail = words.end() - 4;  // R(inf), adaptive, embedded, viscous rate
    EXPECT_NEAR(std::strtod(tail[0].c_str(), nullptr), m.R_infinity, 5.1e-4);
    EXPECT_EQ(tail[1], m.symplectic ? "no" : "yes");
    EXPECT_EQ(tail[2], m.bt_embedded.empty() ? "-" : std::to_string(m.embedded_order));
    const bool keeps = m.reconstructed_rate_order == m.order;
    EXPECT_EQ(tail[3], m.order == 1 ? "secant" : (keeps ? "reconstructed" : "exact"));
    // The words of the summary follow, in their order.
    std::vector<std::string> below;
    for (auto next = line + 1; next != lines.end() && next->starts_with("    "); ++next) {
      for (auto& word : words_of(*next)) below.push_back(std::move(word));
    }
    EXPECT_EQ(below, words_of(m.summary));
  }
}

TEST(MethodsText, FitsATerminal) {
  for (const std::string& line : lines_of(methods_text())) {
    EXPECT_LE(line.size(), 100u) << line;
    EXPECT_TRUE(line.empty() || line.back() != ' ') << line;
  }
}

TEST(MaterialReference, IsUpToDate) {
  std::ifstream stream(source_root() / "docs/laws.md");
  const std::string written{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_TRUE(written == material_reference())
      << "docs/laws.md is stale; write it anew: build/bin/pliant materials --markdown > docs/laws.md, and the "
         "pictures: "
         "build/bin/pliant materials plot LAW --output docs/images/law-LAW.svg";
}

}  // namespace
}  // namespace pliant::test_commands
