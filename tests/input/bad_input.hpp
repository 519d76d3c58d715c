/// A good input, one line of which is made bad, and what is told of it.
#pragma once

#include "base/error.hpp"
#include "input/input.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test {

inline constexpr std::array<const char*, 5> good_lines{
    "mesh: {file: beam.msh}",
    "bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]",
    "constraints: [{surface: clamp, displacement: [0, 0, 0]}]",
    "loads: [{gravity: [0, 0, -9.81]}]",
    "time: {step: 0.01, end: 1}",
};

/// Of this process [s]: what else the machine does is not in it.
inline double processor_time() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

inline std::vector<Diagnostic> mistakes(const std::string& text, const std::vector<Override>& overrides = {}) {
  try {
    read_input(text, "dir/a.yaml", overrides);
    return {};
  } catch (const InputError& error) {
    return error.diagnostics();
  }
}

inline std::string told(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  for (const auto& d : diagnostics) text += to_string(d.where) + ": " + d.message + '\n';
  return text;
}

/// The good input with one line (from 1; one past the end: added) replaced.
inline std::string with_line(std::size_t line, const std::string& replacement) {
  std::string text;
  for (std::size_t i = 1; i <= good_lines.size() + 1; ++i) {
    if (i == line) {
      text += replacement + '\n';
    } else if (i <= good_lines.size()) {
      text += std::string(good_lines[i - 1]) + '\n';
    }
  }
  return text;
}

struct Bad {
  std::size_t line;         ///< of the good input that is replaced
  const char* replacement;  ///< '@' marks where the message must point; none: at the whole file
  const char* message;      ///< a part of it
};

inline void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.replacement;
}

/// With the environment's PLIANT_KEEP_MISTAKES=FOLDER: the input, and beside it what must be told of it at which place,
/// for the program to be run with (tests/program/test_errors.py).
inline void keep_if_wanted(const std::string& text, const Location& where, const char* message) {
  const char* folder = std::getenv("PLIANT_KEEP_MISTAKES");
  if (folder == nullptr) return;
  static int count = 0;
  const std::string name = std::to_string(++count) + ".yaml";
  std::ofstream(folder + ("/" + name)) << text;
  std::ofstream(folder + ("/" + name + ".told")) << to_string({name, where.line, where.column}) << '\n' << message;
}

/// The mistake is told once, at its place.
inline void expect_told_once(const Bad& bad) {
  std::string text = with_line(bad.line, bad.replacement);
  Location expected{"dir/a.yaml", 0, 0};
  if (const std::size_t marker = text.find('@'); marker != std::string::npos) {
    const std::size_t line_start = text.rfind('\n', marker) + 1;
    expected.line = static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(marker), '\n')) + 1;
    expected.column = static_cast<int>(marker - line_start) + 1;
    text.erase(marker, 1);
  }
  keep_if_wanted(text, expected, bad.message);
  const auto found = mistakes(text);
  ASSERT_EQ(found.size(), 1u) << told(found);
  EXPECT_EQ(to_string(found[0].where), to_string(expected)) << told(found);
  EXPECT_NE(found[0].message.find(bad.message), std::string::npos) << told(found);
}

}  // namespace pliant::test
