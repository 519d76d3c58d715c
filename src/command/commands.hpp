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

/// Reads or generates the mesh, partitions it and reports; solves nothing. `page`: a file of HTML that shows the model;
/// empty: none.
ExitCode check_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                       const std::string& page, Console& console);

/// The arguments of `pliant mesh convert`.
struct Conversion {
  std::string from, to;
  std::string size;    ///< target element size with a unit, for geometry; may be empty
  double scale = 1.0;  ///< coordinates are multiplied by it
  bool allows_commands = false;
};

/// Writes a mesh, or the mesh that gmsh makes from a geometry, in Pliant's own format, which ranks read in parallel.
void convert_mesh_command(MPI_Comm comm, const Conversion& conversion, Console& console);

/// Prints the time integration methods.
std::string methods_text();

/// Prints the material laws.
std::string materials_text();

/// Plots stress over stretch of an elastic law to an SVG file, by default <law>.svg, and prints the parameters used.
void plot_material_command(MPI_Comm comm, const std::string& law, const std::vector<std::string>& settings,
                           const std::array<double, 2>& stretches, const std::string& file);

}  // namespace pliant
