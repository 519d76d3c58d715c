/// Commands on what an earlier run has left: continue it, or report what is there.
#pragma once

#include "base/error.hpp"
#include "input/input.hpp"
#include "run/console.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Continues the run of this input that was begun in its output directory, begins it where there is none, and leaves
/// it where it is done. InputError where that run had another input, except for what may change (see resume_command).
ExitCode continue_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                          Console& console);

/// Resumes from a checkpoint, or from the newest one in a directory; from the one before where that is damaged. What
/// may be changed is how long the run is, its steps, solver and output; InputError else.
ExitCode resume_command(MPI_Comm comm, const std::string& place, const std::vector<Override>& overrides,
                        Console& console);

/// What is in a checkpoint, in a result or in the result of a directory, for people. Collective.
std::string info_text(MPI_Comm comm, const std::string& file);

}  // namespace pliant
