/// The errors of a method from its coefficients: orders, error constants, and an embedded formula that estimates the
/// error of a step.
#pragma once

#include "time/method.hpp"

#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// Tolerance of identities between coefficients: published tables are printed with ten digits or more.
inline constexpr double coefficient_tolerance = 1e-9;

/// Order p of the method, determined up to 3. A consistent row.
int convergence_order(const MethodRow& row);

/// Method::reconstructed_rate_order, for rates that act linearly on the motion (viscosity).
int reconstructed_rate_order(const MethodRow& row);

/// C of y_{n+1} - y(t_{n+1}) = C dt^(order+1) y^(order+1) + ... for y' = lambda y with exact past states.
double error_constant(const MethodRow& row, int order);

/// Embedded weights for the same stages, for one-step methods.
struct EmbeddedFormula {
  std::vector<double> bt;  ///< weights of the increments Y_i - y*
  int order = 0;           ///< p^ < p
  double error = 0.0;      ///< c of y_{n+1} - y^_{n+1} ~ c dt^(p^+1) y^(p^+1) for y' = lambda y
};

/// The embedded formula of the highest order below the method's; nothing if the stages leave no freedom for one.
std::optional<EmbeddedFormula> embedded_formula(const MethodRow& row);

/// x^T = r^T L^-1 for the leading n x n block L of the lower triangular A, n the size of r.
std::vector<double> times_inverse(std::span<const double> r, const std::vector<std::vector<double>>& A);

}  // namespace pliant
