/// A simulation with its output: files, log, interruption.
#pragma once

#include "base/error.hpp"
#include "input/config.hpp"
#include "io/checkpoint_file.hpp"
#include "model/model.hpp"
#include "run/console.hpp"

#include <filesystem>

namespace pliant {

/// Runs the simulation that the input describes. Returns done or interrupted. Throws InputError, FileError, or
/// SolveError when the solve failed after every retry; the result then contains the last good state. `additional` terms
/// are added to those of the input. Collective.
ExitCode run_with_output(MPI_Comm comm, const Config& config, Console& console, const TermFactory& additional = {});

/// A checkpoint that was found intact.
struct ResumePoint {
  std::filesystem::path file;
  CheckpointInfo info;
};

/// Likewise from a checkpoint, continuing the results of the run in the output directory. Collective.
ExitCode resume_with_output(MPI_Comm comm, const Config& config, Console& console, const ResumePoint& from,
                            const TermFactory& additional = {});

}  // namespace pliant
