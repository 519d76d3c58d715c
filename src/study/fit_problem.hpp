/// Parameters fitted to measurements, wherever the predictions come from: scaling, several starts, and the statistics
/// of the best minimum.
#pragma once

#include "study/fit_config.hpp"
#include "study/least_squares.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A number that depends on the fitted parameters, with its derivatives by each of them.
struct Sensitive {
  double value;
  std::vector<double> slopes;
};

/// A parameter that is fitted.
struct FreeParameter {
  enum class Fitted { linear, logarithm };
  std::string name;
  std::string unit;  ///< SI
  double lower, upper;
  double size;  ///< what counts as a large change, of the order of its value
  Fitted fitted = Fitted::linear;
};

/// Measurements of one kind, and their prediction. All predictions are NaN where the model does not exist.
struct Measurements {
  std::vector<double> values;
  double weight = 1.0;  ///< of the squared residuals
  std::function<std::vector<Sensitive>(std::span<const double> parameters)> predict;
};

struct FitOutcome {
  std::vector<double> values;  ///< of the parameters
  /// Infinite where the data do not determine the parameter; NaN at a bound, and where there are too few data.
  std::vector<double> standard_errors;
  std::vector<double> correlation;  ///< at [p i + j]
  std::vector<double> sums;         ///< of each group's squared residuals, without its weight
  Determination determination;
  Minimum minimum;
  int num_starts = 0;  ///< that the model could begin from
  int num_best = 0;    ///< that led to the best minimum
};

/// Nothing for a number without a unit.
std::string unit_shown(const std::string& unit);

/// What a user should know of the outcome: no convergence, parameters that the data do not determine, few good starts.
std::vector<std::string> warnings_about(const FitOutcome& outcome, std::span<const FreeParameter> parameters);

class FitProblem {
 public:
  /// `error_of_prediction`: relative to the size of the measurements; smaller residuals are none.
  FitProblem(std::vector<FreeParameter> parameters, std::vector<Measurements> measurements, ResidualKind kind,
             double error_of_prediction = 1e-12);

  /// The best of the minima from `num_starts` starts. `start(n)` is the n-th, n >= 0; those where the model does not
  /// exist are passed over. Not collective.
  FitOutcome solve(int num_starts, const std::function<std::vector<double>(int n)>& start) const;

  /// Residuals of the parameters, group after group, without weights: differences, or ratios of them to the
  /// measurements.
  std::vector<double> residuals(std::span<const double> parameters) const;

 private:
  LeastSquaresProblem least_squares() const;
  std::vector<double> inside(std::span<const double> parameters) const;  ///< as the optimiser sees them
  std::vector<double> outside(std::span<const double> unknowns) const;   ///< and back
  double slope_outside(std::size_t j, double parameter) const;           ///< d parameter / d unknown
  double divisor(double measured) const;
  void add_statistics(FitOutcome& outcome) const;

  std::vector<FreeParameter> parameters_;
  std::vector<Measurements> measurements_;
  ResidualKind kind_;
  double error_of_prediction_;
  double norm_;  ///< of the measurements, by which the optimiser divides
};

}  // namespace pliant
