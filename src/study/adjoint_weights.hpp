/// The derivatives of a number by columns of the history, with which an adjoint begins.
#pragma once

#include "base/error.hpp"
#include "input/config.hpp"

#include <string>
#include <vector>

namespace pliant {

/// A table: for each time, dJ/dy of each column y.
struct AdjointWeights {
  std::string file;
  std::vector<std::string> columns;
  std::vector<double> times;
  std::vector<std::vector<double>> rows;  ///< of each time, one number for each column
  std::vector<int> lines;                 ///< of the file, for each time
};

/// Reads a CSV file with the columns `time` and names of columns of history.csv. Throws InputError. Not collective.
AdjointWeights read_adjoint_weights(const std::string& file);

/// A column of the history that is a component of the position or of the velocity of a probe.
struct ColumnSeed {
  std::size_t probe = 0;
  int component = 0;
  bool is_velocity = false;
};

/// Throws InputError for other columns: those of the history (`all`) that have no adjoint, and unknown ones.
std::vector<ColumnSeed> seeds_of(const AdjointWeights& weights, const Config& config,
                                 const std::vector<std::string>& all);

}  // namespace pliant
