#include "time/order_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace pliant {
namespace {

using StageVector = std::vector<double>;

bool is_zero(double x) {
  return std::abs(x) < coefficient_tolerance;
}

double dot(const StageVector& x, const StageVector& y) {
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

/// A x
StageVector product(const MethodRow& row, const StageVector& x) {
  StageVector y;
  for (const StageVector& A_i : row.A) y.push_back(dot(A_i, x));
  return y;
}

/// x_i y_i
StageVector entrywise(const StageVector& x, const StageVector& y) {
  StageVector z(x.size());
  std::ranges::transform(x, y, z.begin(), std::multiplies());
  return z;
}

/// a x + b (1, ..., 1)
StageVector affine(double a, const StageVector& x, double b) {
  StageVector y(x.size());
  std::ranges::transform(x, y.begin(), [=](double x_i) { return a * x_i + b; });
  return y;
}

double factorial(int k) {
  return k < 2 ? 1.0 : k * factorial(k - 1);
}

/// gamma_k = sum_r alpha_r (1 - r)^k, the moments of the past states for t_n = 0 and dt = 1.
double moment(const MethodRow& row, int k) {
  double sum = 0.0;
  for (std::size_t r = 0; r < row.alpha.size(); ++r) sum += row.alpha[r] * std::pow(-static_cast<double>(r), k);
  return sum;
}

/// tau_i = 1 - beta + beta c_i, the times of the stages for t_n = 0 and dt = 1.
StageVector stage_times(const MethodRow& row) {
  return affine(row.beta, product(row, StageVector(row.b.size(), 1.0)), 1.0 - row.beta);
}

/// sigma_i in Y_i = y_n + tau_i y' + sigma_i y'' + ...
StageVector second_moments(const MethodRow& row, const StageVector& tau) {
  return affine(row.beta, product(row, tau), 0.5 * moment(row, 2));
}

/// The part of x that is orthogonal to all of `directions` (Gram-Schmidt).
StageVector orthogonal_part(StageVector x, std::vector<StageVector> directions) {
  const auto remove = [](StageVector& from, const StageVector& direction) {
    const double size = dot(direction, direction);
    const double share = size > 0.0 ? dot(from, direction) / size : 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) from[i] -= share * direction[i];
  };
  for (std::size_t k = 0; k < directions.size(); ++k) {
    for (std::size_t j = 0; j < k; ++j) remove(directions[k], directions[j]);
    remove(x, directions[k]);
  }
  return x;
}

/// The direction d in which b may change such that order q stays and the error constant of order q changes most; empty
/// if there is none. `error` is that change, R_infinity that of the damping.
struct Freedom {
  StageVector d;
  double error = 0.0;
  double R_infinity = 0.0;
};

Freedom freedom(const MethodRow& row, int q) {
  const StageVector one(row.b.size(), 1.0), c = product(row, one);
  std::vector<StageVector> conditions{one};
  if (q == 2) conditions.push_back(c);
  const StageVector functional = q == 1 ? c : product(row, c);
  std::vector<StageVector> with_damping =
      conditions;  // d^T A^-1 (1, ..., 1) = 0: fast modes do not enter the difference
  StageVector fast(row.b.size());
  for (std::size_t i = 0; i < fast.size(); ++i) {
    fast[i] =
        (1.0 - std::inner_product(fast.begin(), fast.begin() + static_cast<std::ptrdiff_t>(i), row.A[i].begin(), 0.0)) /
        row.A[i][i];
  }
  with_damping.push_back(fast);
  for (const auto& wanted : {with_damping, conditions}) {
    if (wanted.size() >= row.b.size()) continue;
    StageVector d = orthogonal_part(functional, wanted);
    const double error = dot(d, functional);
    if (error > 1e-6 * dot(functional, functional)) return {d, error, dot(d, fast)};
  }
  return {};
}

}  // namespace

// With y* = sum_r alpha_r y(t_n + (1 - r) dt) and Taylor series around t_n, consistency is gamma_0 = 1, gamma_1 + beta
// = 1, sum b = 1; so Y_i = y_n + tau_i y' + sigma_i y'' + ..., sigma = gamma_2 / 2 + beta A tau, and order 2 and 3 ask
// for
//     gamma_2 / 2 + beta b.tau = 1/2
//     gamma_3 / 6 + beta b.tau^2 / 2 = 1/6,   gamma_3 / 6 + beta b.sigma = 1/6
// (one-step: tau = c, the conditions of Hairer & Wanner II, IV.5).
int convergence_order(const MethodRow& row) {
  const StageVector tau = stage_times(row);
  if (!is_zero(moment(row, 2) / 2 + row.beta * dot(row.b, tau) - 1.0 / 2)) return 1;
  const double past = moment(row, 3) / 6 - 1.0 / 6;
  const bool third = is_zero(past + row.beta * dot(row.b, entrywise(tau, tau)) / 2) &&
                     is_zero(past + row.beta * dot(row.b, second_moments(row, tau)));
  return third ? 3 : 2;
}

// The reconstructed rate is (beta A)^-1 (E(Q) - E*), E* = sum_r alpha_r E(q_{n+1-r}). Its q-linear part is the exact
// rate E' V. With Q - q_n = tau q' + sigma q'' + ... (dt = 1) the rest differs from the exact rate E'(Q) V by
//     E'' q' q'     (beta A)^-1 (tau^2 - gamma_2) / 2 - tau                      =: e
//     E'' q' q''    (beta A)^-1 (2 tau sigma - gamma_3) / 2 - tau^2 - sigma
//     E''' q'^3     (beta A)^-1 (tau^3 - gamma_3) / 6 - tau^2 / 2
// in the stages. What reaches y_{n+1} is b^T of these, and b^T (tau e), as the force that the rate causes changes along
// the step; b^T A e vanishes by the conditions of order 3. One-step: b^T A^-1 c^2 = 1 for order 2; b^T A^-1 (c A c) =
// 1/2, b^T A^-1 c^3 = 1, b^T (c A^-1 c^2) = 2/3 for order 3.
int reconstructed_rate_order(const MethodRow& row) {
  const int order = convergence_order(row);
  if (order == 1) return 1;
  const StageVector tau = stage_times(row), tau2 = entrywise(tau, tau), sigma = second_moments(row, tau);
  const double gamma_2 = moment(row, 2), gamma_3 = moment(row, 3);
  /// w^T (beta A)^-1 x
  const auto slopes = [&](const StageVector& w, const StageVector& x) {
    return dot(times_inverse(w, row.A), x) / row.beta;
  };
  if (!is_zero(slopes(row.b, affine(0.5, tau2, -0.5 * gamma_2)) - dot(row.b, tau))) return 1;
  if (order == 2) return 2;
  const StageVector b_tau = entrywise(row.b, tau);
  const bool third =
      is_zero(slopes(row.b, affine(1.0, entrywise(tau, sigma), -0.5 * gamma_3)) - dot(row.b, tau2) -
              dot(row.b, sigma)) &&
      is_zero(slopes(row.b, affine(1.0 / 6, entrywise(tau2, tau), -gamma_3 / 6)) - dot(row.b, tau2) / 2) &&
      is_zero(slopes(b_tau, affine(0.5, tau2, -0.5 * gamma_2)) - dot(b_tau, tau));
  return third ? 3 : 2;
}

// y_{n+1} = R(beta z) sum_r alpha_r e^((1-r) z) y_n, z = lambda dt; R(z) = 1 + sum_k z^k b^T A^(k-1) (1, ..., 1).
double error_constant(const MethodRow& row, int order) {
  const int k = order + 1;
  double C = (moment(row, k) - 1.0) / factorial(k);
  StageVector slopes(row.b.size(), 1.0);
  for (int j = 1; j <= k; ++j) {
    C += std::pow(row.beta, j) * dot(row.b, slopes) * moment(row, k - j) / factorial(k - j);
    slopes = product(row, slopes);
  }
  return C;
}

// b^ = b - theta d. The size of theta is a matter of choice: c scales with it, and so does the answer to fast modes.
// The larger c, the better the difference stands out from rounding and the solver's tolerance; but at c = 0.1 the
// weights of dirk22 and dirk33 would amplify fast modes, |R^(inf)| > 1. So c = 0.1 at most, with |R^(inf)| <= 3/4 (or
// no more than the method's own): 0.064 for dirk22, 0.062 for dirk33. The sign is that which takes R^(inf) towards 0.
std::optional<EmbeddedFormula> embedded_formula(const MethodRow& row) {
  constexpr double moderate_error = 0.1, moderate_damping = 0.75;
  if (row.alpha.size() > 1) return std::nullopt;
  const StageVector bt = times_inverse(row.b, row.A);
  const double R_infinity = 1.0 - std::accumulate(bt.begin(), bt.end(), 0.0);
  for (int q = convergence_order(row) - 1; q >= 1; --q) {
    const Freedom free = freedom(row, q);
    if (free.d.empty()) continue;
    double theta = moderate_error / free.error;
    if (R_infinity * free.R_infinity > 0.0) theta = -theta;
    const double change = std::abs(theta * free.R_infinity);
    const double room = std::abs(R_infinity) + std::max(moderate_damping, std::abs(R_infinity));
    if (change > room) theta *= room / change;
    EmbeddedFormula embedded{{}, q, theta * free.error};
    StageVector b = row.b;
    for (std::size_t i = 0; i < b.size(); ++i) b[i] -= theta * free.d[i];
    embedded.bt = times_inverse(b, row.A);
    return embedded;
  }
  return std::nullopt;
}

StageVector times_inverse(std::span<const double> r, const std::vector<StageVector>& A) {
  StageVector x(r.size());
  for (std::size_t j = r.size(); j-- > 0;) {
    double sum = r[j];
    for (std::size_t k = j + 1; k < r.size(); ++k) sum -= x[k] * A[k][j];
    x[j] = sum / A[j][j];
  }
  return x;
}

}  // namespace pliant
