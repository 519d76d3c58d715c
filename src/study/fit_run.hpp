/// `pliant fit` with a mesh: numbers of an input, fitted to what was measured of a motion.
#pragma once

#include "base/error.hpp"
#include "run/console.hpp"
#include "study/fit_config.hpp"
#include "study/fit_problem.hpp"
#include "study/varied_input.hpp"

#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Measurements of one column of the history.
struct FitTarget {
  FitTargetConfig config;
  std::string name;           ///< for tables: the column and the file
  std::string unit;           ///< SI; "1" where it has none
  double scale = 1.0;         ///< in SI: residuals are divided by it
  std::vector<double> times;  ///< [s], rising
  std::vector<double> values;
  std::vector<double> fitted;  ///< by the run with the fitted values
  std::string note;            ///< on the units of the table; empty if there is none
};

/// A fit by runs and all that follows from it.
struct FittedRun {
  FitConfig config;
  std::vector<VariedNumber> numbers;
  std::vector<FitTarget> targets;
  FitOutcome outcome;
  std::vector<double> residuals;  ///< in units of the scales, target after target
  int num_runs = 0;
  std::string input;  ///< with the fitted values, as YAML
  std::vector<std::string> warnings;
};

/// Runs the fit: least squares of the residuals over their scales, with the derivatives of TangentRun, each run on all
/// ranks. Prints progress and tables; writes fit.csv, fitted.yaml, report.html and the plots in it as SVG files into
/// the directory. Returns done if the fit converged, otherwise study_failed. Throws InputError with every error of the
/// fit file, its tables and the input. Collective.
ExitCode fit_run_command(MPI_Comm comm, const FitConfig& config, const std::string& directory, Console& console);

}  // namespace pliant
