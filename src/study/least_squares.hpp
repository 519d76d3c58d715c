/// Nonlinear least squares with bounds, from several starts, and what the minimum says about its parameters. Knows
/// nothing of where the residuals come from.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// The sum of the squares of r(x) is to be made small for lower <= x <= upper. Parameters are of the order of one.
struct LeastSquaresProblem {
  std::size_t num_residuals;
  std::vector<double> lower, upper;
  /// Sets the residuals [n] and the Jacobian dr_i/dx_j at [p i + j]; NaN where they do not exist.
  std::function<void(std::span<const double> x, std::span<double> r, std::span<double> jacobian)> evaluate;
  /// A residual no longer than this is none: it is left by the errors of the evaluation.
  double error_of_evaluation = 1e-12;

  std::size_t num_parameters() const { return lower.size(); }
};

struct Minimum {
  std::vector<double> x;
  double sum = 0.0;  ///< of the squared residuals
  bool is_converged = false;
  std::string reason;  ///< why the optimiser ended
  int num_iterations = 0;
};

/// The minimum near a start, by Gauss-Newton's method in a trust region (PETSc's TAOBRGN around TAOBNTR). Converged:
/// the residual is orthogonal to the columns of the Jacobian that are not held by a bound, to 1e-6 of its length, or
/// has no length. Not collective.
Minimum minimise(const LeastSquaresProblem& problem, std::span<const double> start);

/// What data say about the parameters at a minimum.
struct Determination {
  std::vector<double> singular_values;     ///< of the Jacobian by the relative changes of the parameters, descending
  std::vector<std::vector<double>> modes;  ///< the direction of each, of length one in the relative changes
  std::vector<bool> is_at_bound;           ///< held by a bound, and left out of all else
  std::vector<bool> is_determined;         ///< no direction that the data do not see moves it
  std::vector<double> covariance;          ///< at [p i + j]; infinite variance where not determined, 0 at bounds
  double variance = 0.0;                   ///< of the residuals: their sum by the degrees of freedom; NaN without any
};

/// The linearised statistics of least squares: covariance = variance (J^T J)^-1. `size`: of each parameter, by which
/// changes count as relative ones. Source: Seber & Wild, Nonlinear Regression (Wiley, 1989), section 5.1. Not
/// collective.
Determination determination(const LeastSquaresProblem& problem, const Minimum& minimum, std::span<const double> size);

/// The n-th point of Halton's sequence in the unit cube: starts that fill it evenly, the same every time. n >= 1.
/// Source: Halton, Numer. Math. 2 (1960) 84-90.
std::vector<double> halton_point(int n, std::size_t dimension);

}  // namespace pliant
