/// Convergence studies: the same problem with finer and finer steps, meshes or tolerances.
#pragma once

#include "base/error.hpp"
#include "input/input.hpp"
#include "run/console.hpp"
#include "study/run_numbers.hpp"

#include <string>
#include <vector>

namespace pliant {

/// What is refined. Steps and mesh sizes are halved from level to level, tolerances are divided by ten.
enum class Refine { time, space, tolerance };

struct StudyOptions {
  Refine refine = Refine::time;
  int levels = 4;
  std::vector<std::string> methods;  ///< empty: the input's
  bool checks_orders = true;         ///< too low an order is a failure
  std::vector<RunNumber> results;    ///< taken from the history of each level
};

/// Observed orders below the theoretical ones by more than this fail a study.
inline constexpr double order_shortfall = 0.3;

/// Runs the study and prints its table, row by row; writes convergence.csv and convergence.svg (in time also work.svg)
/// into the output directory; with `results` also results.csv, and a plot of the error of each.
///
/// In time and by tolerance, errors are distances from dirk33 with a quarter of the finest step or a hundredth of the
/// finest tolerance, and with strain rates that keep its order, as root mean squares over the mass (over the nodes,
/// where there is none) of the displacement [m] and the velocity [m/s] at the end. In
/// space no finer solution is assumed right: the error of a level is its distance from the next one, as root mean
/// square over the volume of the coarsest mesh, and one level more is solved for the last row. Returns done, or
/// shortfall if an observed order, that of the two finest levels, is too low. Collective.
ExitCode converge_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                          const StudyOptions& options, Console& console);

}  // namespace pliant
