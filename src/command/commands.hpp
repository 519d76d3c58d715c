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

/// Resumes the run of this input that was begun in its output directory, starts it if there is none, and leaves it as
/// it is if it is finished. InputError if that run had another input, except for what may change (see resume_command).
ExitCode continue_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                          Console& console);

/// Resumes from a checkpoint, or from the newest one in a directory, or the one before if that is damaged. The duration
/// of the run, its steps, solver and output may be changed; InputError for anything else.
ExitCode resume_command(MPI_Comm comm, const std::string& place, const std::vector<Override>& overrides,
                        Console& console);

/// What is in a checkpoint, in a result or in the result of a directory, for people. Collective.
std::string info_text(MPI_Comm comm, const std::string& file);

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

/// The same as a page of the documentation, docs/laws.md.
std::string material_reference();

/// Draws stress over stretch of an elastic law into an SVG file, by default <law>.svg, and says with which parameters.
void plot_material_command(MPI_Comm comm, const std::string& law, const std::vector<std::string>& settings,
                           const std::array<double, 2>& stretches, const std::string& file);

}  // namespace pliant
