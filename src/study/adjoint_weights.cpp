#include "study/adjoint_weights.hpp"

#include "base/text.hpp"
#include "study/fit_data.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace pliant {

AdjointWeights read_adjoint_weights(const std::string& file) {
  const NumberTable table = read_numbers(file, {"--adjoint " + file, 0, 0});
  const auto time = static_cast<std::size_t>(std::ranges::find(table.names, "time") - table.names.begin());
  if (time == table.names.size()) {
    throw InputError({file, 1, 1},
                     "the table has no column 'time'; its header must be 'time' and names of columns of "
                     "history.csv, e.g. time,tip_z");
  }
  if (table.names.size() == 1) throw InputError({file, 1, 1}, "the table needs a column in addition to 'time'");
  AdjointWeights weights{file, {}, table.columns[time], {}, table.lines};
  weights.rows.resize(weights.times.size());
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (c == time) continue;
    weights.columns.push_back(table.names[c]);
    for (std::size_t row = 0; row < weights.rows.size(); ++row) weights.rows[row].push_back(table.columns[c][row]);
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
