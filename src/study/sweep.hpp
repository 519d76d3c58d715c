/// Parameter sweeps: runs of one input with other values, side by side, and a summary of their results.
#pragma once

#include "base/error.hpp"
#include "input/tree.hpp"
#include "run/console.hpp"
#include "study/processes.hpp"
#include "study/run_numbers.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace pliant {

struct SweepOptions {
  int at_once = 0;                         ///< runs at a time; 0: as many as the processors allow
  int ranks = 1;                           ///< of each run
  bool continues = false;                  ///< skip finished runs, resume those that were begun
  int samples = 0;                         ///< how many points are taken from the ranges
  std::uint64_t seed = 1;                  ///< of the samples
  std::vector<std::string> logarithmic;    ///< keys whose ranges are sampled by factors
  std::vector<std::string> together;       ///< "KEY,KEY": keys whose lists are gone through side by side
  std::vector<RunNumber> results;          ///< taken from each run
  std::vector<std::string> petsc_options;  ///< of each run
  Environment environment;                 ///< of each run
};

/// Runs the input once for every combination of the swept values: a list in `changes`, where the input takes no list
/// (or a list of such, where it takes one), is swept; the other changes hold for all. Ranges, as in "900..1100", are
/// sampled: a Latin hypercube of `samples` points in all of them, for every combination of the lists. Each run has a
/// directory of its own in `output.directory`, named after its values. Prints a table, and writes sweep.csv (one row
/// for each run: its values, how it ended, the results, the last row of its history) and, for every column of the
/// history that varies, a plot of all runs over time, and plots of each result over the swept values. Values that are
/// not valid throw InputError before anything runs. Returns done; the exit code of the first run that failed;
/// interrupted after `stop_signals`, which the runs get too. One process only.
ExitCode sweep_command(const std::string& file, const std::vector<Override>& changes, const SweepOptions& options,
                       Console& console);

}  // namespace pliant
