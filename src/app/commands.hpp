/// The commands of the program. Each is collective and prints on rank 0.
#pragma once

#include "app/console.hpp"
#include "app/input.hpp"
#include "base/error.hpp"

#include <array>
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

/// The same as a page of the documentation, docs/laws.md.
std::string material_reference();

/// Draws stress over stretch of an elastic law into an SVG file, by default <law>.svg, and says with which parameters.
void plot_material_command(MPI_Comm comm, const std::string& law, const std::vector<std::string>& settings,
                           const std::array<double, 2>& stretches, const std::string& file);

}  // namespace pliant
