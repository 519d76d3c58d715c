#include "base/text.hpp"

#include <array>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_text {
namespace {

TEST(EditDistance, CountsChangesOfOneLetter) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("step", "step"), 0);
  EXPECT_EQ(edit_distance("step", "stp"), 1);
  EXPECT_EQ(edit_distance("step", "sstep"), 1);
  EXPECT_EQ(edit_distance("step", "stop"), 1);
  EXPECT_EQ(edit_distance("step", "setp"), 1) << "a swap of neighbours is one mistake";
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("Step", "sTEP"), 0);
}

TEST(DidYouMean, FindsTheNearKeyAndOnlyThat) {
  const std::vector<std::string> keys{"model", "youngs_modulus", "poissons_ratio", "P1"};
  EXPECT_EQ(closest("youngs_modulos", keys), "youngs_modulus");
  EXPECT_EQ(closest("poisson_ratio", keys), "poissons_ratio");
  EXPECT_EQ(closest("p1", keys), "P1");
  EXPECT_EQ(closest("colour", keys), std::nullopt);
  EXPECT_EQ(closest("poisson", keys), "poissons_ratio");
  EXPECT_EQ(closest("", keys), std::nullopt);
  EXPECT_EQ(closest(std::string(100000, 'x'), keys), std::nullopt);
  EXPECT_EQ(did_you_mean("modle", keys), " (did you mean 'model'?)");
  EXPECT_EQ(did_you_mean("xyzzy", keys), "");
  const std::vector<std::string> columns{"step", "tip_x", "tip_y", "tip_z"};
  EXPECT_EQ(did_you_mean("tip", columns), " (did you mean 'tip_x', 'tip_y' or 'tip_z'?)");
}

TEST(ParseNumber, TakesWholeTextsOnly) {
  for (const auto& [text, value] : std::vector<std::pair<std::string, double>>{
           {"1", 1}, {"-1.5e-3", -1.5e-3}, {"+2", 2}, {".5", 0.5}, {"5.", 5}, {"1E6", 1e6}}) {
    EXPECT_EQ(parse_number(text), value) << text;
  }
  for (const char* text :
       {"", " ", "1 ", " 1", "1,5", "1e", "e5", "0x10", "inf", "nan", "-", "+-1", "--1", "1_000", "1e999"}) {
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
  }
}

TEST(FormatNumber, ReadsBackExactly) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, -5e300, 2.0, std::numeric_limits<double>::denorm_min(),
                             std::numeric_limits<double>::max()}) {
    EXPECT_EQ(parse_number(format_number(value)), value);
  }
  EXPECT_EQ(format_number(0.1), "0.1");
}

TEST(Excerpt, KeepsMessagesOnOneLineAndCharactersWhole) {
  EXPECT_EQ(excerpt("a\nb\x1b[31m"), "a b [31m");
  EXPECT_EQ(excerpt(std::string(100, 'x'), 5), "xxxxx...");
  EXPECT_EQ(excerpt("\u00e9\u00e9", 3), "\u00e9...");
}

TEST(Wrapped, KeepsWordsWholeAndLinesShort) {
  EXPECT_EQ(wrapped("a bb  ccc\nd", 6, 1), " a bb\n ccc d\n");
  EXPECT_EQ(wrapped("a bb ccc d", 7, 1), " a bb\n ccc d\n");
  EXPECT_EQ(wrapped("a bb ccc d", 9, 1), " a bb ccc\n d\n");
  EXPECT_EQ(wrapped("a long word", 3, 0), "a\nlong\nword\n");
  EXPECT_EQ(wrapped(" \n", 10, 2), "");
}

TEST(Utf8, FindsTheFirstBadByte) {
  EXPECT_EQ(first_invalid_utf8("plain"), std::nullopt);
  EXPECT_EQ(first_invalid_utf8("m\u00b2 \u20ac \U0001F600"), std::nullopt);
  EXPECT_EQ(first_invalid_utf8("caf\xE9"), 3u);
  EXPECT_EQ(first_invalid_utf8("\xC0\xAF"), 0u) << "overlong";
  EXPECT_EQ(first_invalid_utf8("\xED\xA0\x80"), 0u) << "surrogate";
  EXPECT_EQ(first_invalid_utf8("a\xF4\x90\x80\x80"), 1u) << "beyond Unicode";
  EXPECT_EQ(first_invalid_utf8("ab\xE2\x82"), 2u) << "cut off";
}

}  // namespace
}  // namespace pliant::test_text
