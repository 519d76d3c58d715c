#include "study/adjoint_weights.hpp"

#include "base/text.hpp"
#include "io/history_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace pliant {

AdjointWeights read_adjoint_weights(const std::string& file) {
  if (!std::filesystem::is_regular_file(file)) {
    throw InputError({"--adjoint " + file, 0, 0}, fmt::format("there is no file '{}'", file));
  }
  const HistoryTable table = read_history(file);
  AdjointWeights weights{file, {}, {}, {}};
  const std::vector<double>* times = table.find("time");
  if (times == nullptr) {
    throw InputError({file, 1, 1},
                     "the table has no column 'time'; its header must be 'time' and names of columns of "
                     "history.csv, e.g. time,tip_z");
  }
  weights.times = *times;
  weights.rows.resize(times->size());
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (&table.columns[c] == times) continue;
    weights.columns.push_back(table.names[c]);
    for (std::size_t row = 0; row < weights.rows.size(); ++row) weights.rows[row].push_back(table.columns[c][row]);
  }
  if (weights.columns.empty() || weights.rows.empty()) {
    throw InputError({file, 1, 1},
                     "the table has no numbers: it needs a column in addition to 'time', and at least one row");
  }
  for (std::size_t row = 0; row < weights.rows.size(); ++row) {
    const bool is_complete = std::isfinite(weights.times[row]) &&
                             std::ranges::all_of(weights.rows[row], [](double w) { return std::isfinite(w); });
    if (!is_complete) {
      throw InputError({file, static_cast<int>(row) + 2, 1}, "a number is missing, or not finite");
    }
  }
  return weights;
}

std::vector<ColumnSeed> seeds_of(const AdjointWeights& weights, const Config& config,
                                 const std::vector<std::string>& all) {
  constexpr std::array<std::string_view, 6> suffixes{"_x", "_y", "_z", "_vx", "_vy", "_vz"};
  std::vector<ColumnSeed> seeds;
  for (const std::string& column : weights.columns) {
    const std::size_t before = seeds.size();
    for (std::size_t p = 0; p < config.probes.size(); ++p) {
      for (int i = 0; i < 6; ++i) {
        if (column == config.probes[p].name + std::string(suffixes[static_cast<std::size_t>(i)])) {
          seeds.push_back({p, i % 3, i >= 3});
        }
      }
    }
    if (seeds.size() == before + 1) continue;
    if (std::ranges::find(all, column) == all.end()) {
      throw InputError({weights.file, 1, 1}, fmt::format("history.csv has no column '{}'{}; it has {}", column,
                                                         did_you_mean(column, all), joined(all)));
    }
    throw InputError({weights.file, 1, 1},
                     fmt::format("'{}' has no adjoint: weights are of positions and velocities of probes, such as "
                                 "tip_z or tip_vx; `--of {}` differentiates it",
                                 column, column));
  }
  return seeds;
}

}  // namespace pliant
