/// Plots of what a sweep found over what it varied.
#pragma once

#include "io/svg_axes.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// What a sweep gave one key of the input, run by run.
struct SweptValues {
  std::string name;                 ///< short, for labels
  std::vector<std::string> texts;   ///< as typed, "5 ms"
  std::string unit;                 ///< of those without one; may be empty
  bool is_sampled = false;          ///< from a range, instead of a list
  std::optional<Scale> scale = {};  ///< of its axis; by default what suits the values
};

/// The values as numbers of `unit`, run by run; nothing if one of them is not such a number.
std::optional<std::vector<double>> si_values(const SweptValues& values);

/// A result of each run; NaN where it has none.
struct SweptResult {
  std::string name, unit;
  std::vector<double> values;
};

/// "step=5 ms,method=bdf2": the values of a run, without those of the keys in `except`.
std::string label_of(const std::vector<SweptValues>& keys, std::size_t run,
                     const std::vector<std::size_t>& except = {});

/// Writes DIRECTORY/RESULT.svg, over the key with the most numbers, one curve for each choice of the others; of samples
/// DIRECTORY/RESULT_over_KEY.svg for each sampled key, one mark for each run. Where exactly two keys have numbers, a
/// map over both too: DIRECTORY/RESULT_map.svg, or one for each choice of the other keys. Returns how many files. Not
/// collective.
std::size_t draw_result(const std::vector<SweptValues>& keys, const SweptResult& result,
                        const std::filesystem::path& directory);

}  // namespace pliant
