/// `pliant fit`: from measurements to the constants of a material.
#pragma once

#include "base/error.hpp"
#include "run/console.hpp"
#include "study/fit_material.hpp"
#include "study/fit_problem.hpp"
#include "study/fit_stability.hpp"
#include "study/fit_tests.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// A fit and all that follows from it.
struct FittedMaterial {
  FitConfig config;
  FitMaterial material;
  std::vector<MaterialTest> tests;
  FitOutcome outcome;
  std::vector<double> all;        ///< values of all parameters of the material
  std::vector<double> residuals;  ///< test after test
  std::vector<StabilityRange> stability;
  std::vector<std::string> warnings, notes;
};

/// The fit that the text of a file describes; `file`: its name, to whose directory tables are relative. Throws
/// InputError with every error. Not collective.
FittedMaterial fit_material(const std::string& text, const std::string& file);

/// Removes what an earlier fit has left in a directory. Not collective.
void remove_results(const std::filesystem::path& directory);

/// Runs the fit, prints its tables, and writes fit.csv, material.yaml, report.html and the plots in it as SVG files
/// into the directory `output`. Returns done if the fit converged, otherwise study_failed. A fit of numbers of an input
/// is that of study/fit_run.hpp. Collective; rank 0 does the work.
ExitCode fit_command(MPI_Comm comm, const std::string& file, const std::string& output, Console& console);

}  // namespace pliant
