/// A fit by runs as text, as files and as a page.
#pragma once

#include "study/fit_run.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// Parameters with their standard errors and targets with their residuals, as lines of a terminal.
std::vector<std::string> fit_tables(const FittedRun& fit);

/// R^2 of the n-th target: 1 - the sum of the squared differences / that of the measurements from their mean.
double determination_of(const FittedRun& fit, std::size_t n);

/// Writes fit.csv (parameter,value,standard_error,unit in SI units), fitted.yaml (the input with the fitted values),
/// report.html, and for each target two plots: measurements with the fitted motion, and residuals. Not collective.
void write_fit(const FittedRun& fit, const std::filesystem::path& directory);

}  // namespace pliant
