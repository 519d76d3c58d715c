/// A fit as text: tables for the terminal, fit.csv, and the lines to paste into an input.
#pragma once

#include "study/fit.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Parameters with their standard errors and tests with their residual sums, as lines of a terminal.
std::vector<std::string> fit_tables(const FittedMaterial& fit);

/// parameter,value,standard_error,unit in SI units: fitted parameters, then those held, which have no error.
std::string fit_csv(const FittedMaterial& fit);

/// The body's elasticity and viscosity as an input has them, and the treatment that an incompressible body needs.
std::string material_yaml(const FittedMaterial& fit);

/// The law and the tests in one line.
std::string fit_heading(const FittedMaterial& fit);

/// One test's residuals.
struct TestSummary {
  std::string name;
  std::size_t count;
  double sum;            ///< of the squared residuals [Pa^2], or of relative ones [1]
  double mean_square;    ///< root of their mean [Pa] or [1]
  double determination;  ///< R^2: 1 - sum of the squared differences / that of the measurements from their mean
};
std::vector<TestSummary> summaries_of(const FittedMaterial& fit);

}  // namespace pliant
