/// Results of several runs, side by side.
#pragma once

#include "base/error.hpp"
#include "run/console.hpp"

#include <string>
#include <vector>

namespace pliant {

struct CompareOptions {
  std::vector<std::string> runs;     ///< directories of results, or files history.csv
  std::vector<std::string> columns;  ///< of the histories; empty: all that describe the bodies
  std::string output = "compare";    ///< directory
};

/// Prints, for each column, the largest difference of each run from the first over the time that both cover, and where
/// it is. Histories with other steps are interpolated along straight lines. Writes compare.csv and, for each column
/// that varies, a plot of all runs and one of the differences. Throws InputError for a run without a history or a
/// column that none has, FileError for one that does not exist. One process only.
ExitCode compare_command(const CompareOptions& options, Console& console);

}  // namespace pliant
