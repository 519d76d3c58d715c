/// `pliant sensitivity --adjoint`: the derivatives of one number by many numbers and fields of an input.
#pragma once

#include "base/error.hpp"
#include "input/tree.hpp"
#include "run/console.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

struct GradientOptions {
  std::string weights;               ///< a CSV file: dJ/dy of columns y of the history over time
  std::vector<std::string> numbers;  ///< of the input, named as for --set
  std::vector<std::string> fields;   ///< constants of bodies with a value in each cell; initial.velocity, ...
  std::int64_t kept_steps = 0;       ///< AdjointRun
};

/// Runs the input, goes back through it with the weights (study/adjoint_run.hpp), and writes the derivatives of
/// J = sum of dJ/dy y:
///
///   gradient.csv        number,value,unit,derivative of each number; SI units
///   gradient_cells.csv  cell,x,y,z, and for each constant its value in the cell and the derivative by it
///   gradient_nodes.csv  vertex,x,y,z, and the derivatives by initial velocities and displacements
///   gradient.h5, .xdmf  the fields, for ParaView
///
/// Files without content are not written. Throws InputError for unknown columns, numbers and fields and for inputs
/// without an adjoint, SolveError where the run fails. Collective.
ExitCode gradient_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                          const GradientOptions& options, Console& console);

}  // namespace pliant
