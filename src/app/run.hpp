/// A simulation with its output: files, log, interruption.
#pragma once

#include "app/config.hpp"
#include "app/console.hpp"
#include "base/error.hpp"

namespace pliant {

/// Runs what the input describes. Returns done or interrupted; throws InputError, FileError, or SolveError when the
/// solve failed after every retry (the last good state is in the result then). Collective.
ExitCode run_with_output(MPI_Comm comm, const Config& config, Console& console);

}  // namespace pliant
