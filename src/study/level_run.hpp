/// One run of a convergence study, without files.
#pragma once

#include "model/model.hpp"
#include "run/console.hpp"
#include "study/run_numbers.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// The end of a run.
struct LevelRun {
  std::string failure;  ///< empty if it was solved
  Handle<Vec> q, v;
  std::int64_t steps = 0;
  long long newton_iterations = 0;
  double seconds = 0.0;
  double largest_q = 0.0;       ///< maximum over time of the root mean square [m]
  double largest_v = 0.0;       ///< likewise [m/s]
  std::vector<double> results;  ///< one for each number that was asked for
};

/// Reports the warnings of a model that the console has not shown yet. Not collective.
void report_new_warnings(const Model& model, Console& console);

/// Runs the input; `model` is its model. `numbers`: taken from its history; InputError if it
/// does not have their columns. On a terminal, shows its progress as
/// `name`. Collective.
LevelRun run_level(const Config& config, Model& model, std::span<const RunNumber> numbers, const std::string& name,
                   Console& console);

}  // namespace pliant
