/// The commands of the program. Each is collective and prints on rank 0.
#pragma once

#include "base/error.hpp"
#include "input/input.hpp"
#include "run/console.hpp"

#include <array>
#include <string>
#include <vector>

namespace pliant {

ExitCode run_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides, Console& console);

/// Reads, meshes and partitions; reports, solves nothing.
ExitCode check_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                       Console& console);

/// How `pliant mesh convert` is called.
struct Conversion {
  std::string from, to;
  std::string size;    ///< target element size with a unit, for geometry; may be empty
  double scale = 1.0;  ///< coordinates are multiplied by it
  bool allows_commands = false;
};

/// Writes a mesh, or what gmsh makes of a geometry, in the format that every rank reads its part of.
void convert_mesh_command(MPI_Comm comm, const Conversion& conversion, Console& console);

/// The integrators, for people.
std::string methods_text();

/// The laws, for people.
std::string materials_text();

/// Draws stress over stretch of an elastic law into an SVG file, by default <law>.svg, and says with which parameters.
void plot_material_command(MPI_Comm comm, const std::string& law, const std::vector<std::string>& settings,
                           const std::array<double, 2>& stretches, const std::string& file);

}  // namespace pliant
