/// The commands of the program. Each is collective and prints on rank 0.
#pragma once

#include "app/console.hpp"
#include "app/input.hpp"
#include "base/error.hpp"

#include <string>
#include <vector>

namespace pliant {

ExitCode run_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides, Console& console);

/// Reads, meshes and partitions; reports, solves nothing.
ExitCode check_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                       Console& console);

/// The integrators, for people.
std::string methods_text();

/// The laws, for people.
std::string materials_text();

}  // namespace pliant
