/// `pliant modes`: natural frequencies and mode shapes of a body, at rest or under load.
#pragma once

#include "base/error.hpp"
#include "input/tree.hpp"
#include "run/console.hpp"

#include <optional>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

struct ModesOptions {
  int number = 10;             ///< of modes
  std::optional<double> near;  ///< modes with frequencies nearest to this one [Hz]; empty: the lowest
  bool is_unloaded = false;    ///< about the undeformed state, even where the input is static
  std::string output;          ///< directory; empty: `modes` in that of the input's results
};

/// Finds the modes of M q'' + K q = 0 (study/vibration.hpp): with `time.method: static` about the equilibrium at the
/// end of the load, otherwise about the undeformed state without loads, contact and prescribed displacements. Prints a
/// table; writes modes.csv, one row for each mode (study/mode_files.hpp), and result.h5 with result.xdmf, one frame for
/// each mode. Throws InputError without a mass or a potential, SolveError where the equilibrium or the modes
/// are not found. Collective.
ExitCode modes_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                       const ModesOptions& options, Console& console);

}  // namespace pliant
