/// A fit as text: tables for the terminal, fit.csv, and the lines to paste into an input.
#pragma once

#include "study/fit.hpp"

#include <optional>
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

/// A number with so many digits, "-" if it is not known.
std::string number_in_table(double value, int digits);
/// All digits, `inf`, or nothing if it is not known.
std::string number_in_csv(double value);
/// R^2 from the sum of the squared differences and that of the measurements from their mean; NaN if these are all
/// alike.
double determination_of(double differences, double spread);
/// There is one if the curve describes its measurements worse than their mean does.
std::optional<std::string> warning_about_determination(const std::string& name, double determination);
/// Five decimals, "-" if it is not known.
std::string determination_shown(double determination);

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
