/// `pliant sensitivity`: how the history of a run depends on numbers of its input.
#pragma once

#include "base/error.hpp"
#include "input/tree.hpp"
#include "run/console.hpp"

#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

struct SensitivityOptions {
  std::vector<std::string> columns;  ///< of history.csv
  std::vector<std::string> numbers;  ///< of the input, named as for --set
};

/// Runs the input with the derivatives of the columns by the numbers (study/tangent_run.hpp). Writes sensitivity.csv,
/// one row for each step: time, and for each column y its value, and for each number p the derivative dy/dp and the
/// relative one, p dy/dp; in SI units. Writes
/// numbers.csv (number,value,unit), a plot of the relative ones for each column, and prints those at the end.
/// Throws InputError for unknown columns and numbers, SolveError where the run fails; what was computed until then is
/// written. Collective.
ExitCode sensitivity_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                             const SensitivityOptions& options, Console& console);

}  // namespace pliant
