#include "study/fit_problem.hpp"

#include "base/limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {

FitProblem::FitProblem(std::vector<FreeParameter> parameters, std::vector<Measurements> measurements, ResidualKind kind,
                       double error_of_prediction)
    : parameters_(std::move(parameters)),
      measurements_(std::move(measurements)),
      kind_(kind),
      error_of_prediction_(error_of_prediction),
      norm_(0.0) {
  for (const Measurements& group : measurements_) {
    for (const double y : group.values) norm_ += group.weight * std::pow(y / divisor(y), 2);
  }
  norm_ = norm_ > 0.0 ? std::sqrt(norm_) : 1.0;
}

double FitProblem::divisor(double measured) const {
  return kind_ == ResidualKind::relative ? measured : 1.0;
}

std::vector<double> FitProblem::inside(std::span<const double> parameters) const {
  std::vector<double> unknowns;
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const bool is_log = parameters_[j].fitted == FreeParameter::Fitted::logarithm;
    unknowns.push_back(is_log ? std::log(parameters[j]) : parameters[j] / parameters_[j].size);
  }
  return unknowns;
}

std::vector<double> FitProblem::outside(std::span<const double> unknowns) const {
  std::vector<double> parameters;
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const bool is_log = parameters_[j].fitted == FreeParameter::Fitted::logarithm;
    parameters.push_back(is_log ? std::exp(unknowns[j]) : unknowns[j] * parameters_[j].size);
  }
  return parameters;
}

double FitProblem::slope_outside(std::size_t j, double parameter) const {
  return parameters_[j].fitted == FreeParameter::Fitted::logarithm ? parameter : parameters_[j].size;
}

LeastSquaresProblem FitProblem::least_squares() const {
  LeastSquaresProblem problem;
  std::vector<double> lower, upper;
  for (const FreeParameter& p : parameters_) {
    lower.push_back(p.lower);
    upper.push_back(p.upper);
  }
  problem.lower = inside(lower);
  problem.upper = inside(upper);
  problem.error_of_evaluation = error_of_prediction_;
  problem.num_residuals = 0;
  for (const Measurements& group : measurements_) problem.num_residuals += group.values.size();
  problem.evaluate = [this](std::span<const double> x, std::span<double> r, std::span<double> jacobian) {
    const std::vector<double> parameters = outside(x);
    std::size_t row = 0;
    for (const Measurements& group : measurements_) {
      const auto predicted = group.predict(parameters);
      for (std::size_t i = 0; i < group.values.size(); ++i, ++row) {
        const double factor = std::sqrt(group.weight) / (divisor(group.values[i]) * norm_);
        r[row] = factor * (predicted[i].value - group.values[i]);
        for (std::size_t j = 0; j < parameters.size(); ++j) {
          jacobian[row * parameters.size() + j] = factor * predicted[i].slopes[j] * slope_outside(j, parameters[j]);
        }
      }
    }
  };
  return problem;
}

std::vector<double> FitProblem::residuals(std::span<const double> parameters) const {
  std::vector<double> result;
  for (const Measurements& group : measurements_) {
    const auto predicted = group.predict(parameters);
    for (std::size_t i = 0; i < group.values.size(); ++i) {
      result.push_back((predicted[i].value - group.values[i]) / divisor(group.values[i]));
    }
  }
  return result;
}

FitOutcome FitProblem::solve(int num_starts, const std::function<std::vector<double>(int n)>& start) const {
  constexpr int tries = 50;  // for each start
  constexpr double same = 1e-6;
  const LeastSquaresProblem problem = least_squares();
  std::vector<Minimum> minima;
  const int wanted = parameters_.empty() ? 1 : num_starts;
  for (int n = 0; n < tries * wanted && static_cast<int>(minima.size()) < wanted; ++n) {
    std::vector<double> from = inside(start(n));
    for (std::size_t j = 0; j < from.size(); ++j) from[j] = std::clamp(from[j], problem.lower[j], problem.upper[j]);
    Minimum minimum = minimise(problem, from);
    if (std::isfinite(minimum.sum)) minima.push_back(std::move(minimum));
  }
  FitOutcome outcome;
  if (minima.empty()) {
    outcome.values.assign(parameters_.size(), nan);
    outcome.minimum.reason = "the law does not exist at the measured stretches, wherever the fit starts";
    return outcome;
  }
  const auto is_better = [](const Minimum& a, const Minimum& b) {
    return a.is_converged != b.is_converged ? a.is_converged : a.sum < b.sum;
  };
  outcome.minimum = *std::ranges::min_element(minima, is_better);
  outcome.num_starts = static_cast<int>(minima.size());
  outcome.num_best = static_cast<int>(std::ranges::count_if(
      minima, [&](const Minimum& m) { return m.is_converged && m.sum <= outcome.minimum.sum * (1.0 + same) + 1e-24; }));
  outcome.values = outside(outcome.minimum.x);
  add_statistics(outcome);
  return outcome;
}

void FitProblem::add_statistics(FitOutcome& outcome) const {
  const std::size_t p = parameters_.size();
  std::vector<double> sizes;  // relative changes, in the optimiser's unknowns
  for (std::size_t j = 0; j < p; ++j) {
    const bool is_linear = parameters_[j].fitted == FreeParameter::Fitted::linear && outcome.values[j] != 0.0;
    sizes.push_back(is_linear ? std::abs(outcome.values[j] / parameters_[j].size) : 1.0);
  }
  outcome.determination = determination(least_squares(), outcome.minimum, sizes);
  auto& covariance = outcome.determination.covariance;
  for (std::size_t i = 0; i < p; ++i) {
    for (std::size_t j = 0; j < p; ++j) {
      covariance[p * i + j] *= slope_outside(i, outcome.values[i]) * slope_outside(j, outcome.values[j]);
    }
  }
  for (std::size_t i = 0; i < p; ++i) {
    outcome.standard_errors.push_back(outcome.determination.is_at_bound[i] ? std::numeric_limits<double>::quiet_NaN()
                                                                           : std::sqrt(covariance[p * i + i]));
    for (std::size_t j = 0; j < p; ++j) {
      outcome.correlation.push_back(covariance[p * i + j] / std::sqrt(covariance[p * i + i] * covariance[p * j + j]));
    }
  }
  const std::vector<double> all = residuals(outcome.values);
  auto next = all.begin();
  for (const Measurements& group : measurements_) {
    double sum = 0.0;
    for (std::size_t i = 0; i < group.values.size(); ++i, ++next) sum += *next * *next;
    outcome.sums.push_back(sum);
  }
}

std::string unit_shown(const std::string& unit) {
  return unit == "1" ? "" : unit;
}

std::vector<std::string> warnings_about(const FitOutcome& outcome, std::span<const FreeParameter> parameters) {
  std::vector<std::string> warnings;
  const Determination& known = outcome.determination;
  if (!outcome.minimum.is_converged) {
    warnings.push_back(fmt::format("the fit has not converged ({}); try more starts, closer bounds or another model",
                                   outcome.minimum.reason));
  }
  for (std::size_t j = 0; j < known.is_determined.size(); ++j) {
    const std::string& name = parameters[j].name;
    if (known.is_at_bound[j]) {
      const std::string unit = unit_shown(parameters[j].unit);
      warnings.push_back(fmt::format("'{}' is at a bound, {:.6g}{}{}; it has no standard error", name,
                                     outcome.values[j], unit.empty() ? "" : " ", unit));
    } else if (!known.is_determined[j]) {
      warnings.push_back(fmt::format("the data do not determine '{}'; add measurements that do, or hold it", name));
    } else if (outcome.standard_errors[j] > std::abs(outcome.values[j])) {
      warnings.push_back(
          fmt::format("the data hardly determine '{}': its standard error is larger than its value", name));
    }
  }
  if (!known.is_determined.empty() && std::isnan(known.variance)) {
    warnings.emplace_back("standard errors are unknown: they need more measurements than parameters");
  }
  constexpr int several = 5;
  if (outcome.minimum.is_converged && outcome.num_starts >= several && outcome.num_best == 1) {
    warnings.push_back(
        fmt::format("only one of {} starts led to the best minimum, so there may be a better one; try more starts",
                    outcome.num_starts));
  }
  return warnings;
}

}  // namespace pliant
