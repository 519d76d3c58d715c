#include "time/method.hpp"

#include "time/bdf.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

namespace pliant {
namespace {

constexpr double tolerance = 1e-12;  // of identities between coefficients of size one, written in double precision

bool is_zero(double x) {
  return std::abs(x) < tolerance;
}

std::string row_number(std::size_t i) {
  return std::to_string(i + 1);
}

std::optional<std::string> refuse_shape(const MethodRow& row) {
  const std::size_t s = row.b.size();
  if (row.name.empty()) return "it has no name";
  if (row.alpha.empty()) return "alpha is empty: there must be a past state";
  if (s == 0 || row.A.size() != s) return "A must be square, with as many rows as b has entries";
  for (const auto& A_i : row.A) {
    if (A_i.size() != s) return "A must be square, with as many rows as b has entries";
  }
  const auto finite = [](double x) { return std::isfinite(x); };
  bool all_finite =
      std::isfinite(row.beta) && std::ranges::all_of(row.alpha, finite) && std::ranges::all_of(row.b, finite);
  for (const auto& A_i : row.A) all_finite = all_finite && std::ranges::all_of(A_i, finite);
  if (!all_finite) return "a coefficient is not a finite number";
  return std::nullopt;
}

std::optional<std::string> refuse_stages(const MethodRow& row) {
  if (row.beta <= 0.0) return "beta must be positive";
  for (std::size_t i = 0; i < row.A.size(); ++i) {
    for (std::size_t j = i + 1; j < row.A.size(); ++j) {
      if (row.A[i][j] != 0.0) {
        return "A is not lower triangular: stage " + row_number(i) + " depends on stage " + row_number(j) +
               ", and coupled stages are not solved";
      }
    }
    if (row.A[i][i] == 0.0) return "stage " + row_number(i) + " is explicit (A has a zero on its diagonal)";
    if (row.A[i][i] < 0.0) return "stage " + row_number(i) + " goes backward (A is negative on its diagonal)";
  }
  return std::nullopt;
}

std::optional<std::string> refuse_inconsistency(const MethodRow& row) {
  double sum_alpha = 0.0, lag = 0.0;
  for (std::size_t r = 0; r < row.alpha.size(); ++r) {
    sum_alpha += row.alpha[r];
    lag += static_cast<double>(r) * row.alpha[r];
  }
  const double sum_b = std::accumulate(row.b.begin(), row.b.end(), 0.0);
  if (!is_zero(sum_alpha - 1.0)) return "it is inconsistent: alpha does not sum to 1";
  if (!is_zero(sum_b - 1.0)) return "it is inconsistent: b does not sum to 1";
  if (!is_zero(row.beta - lag - 1.0)) return "it is inconsistent: beta does not fit alpha";
  if (row.alpha.size() == 1) return std::nullopt;

  const std::size_t l = row.alpha.size();
  if (row.b.size() > 1 || row.A[0][0] != 1.0) return "several past states go with the single stage A = [1] only";
  if (l > max_bdf_steps) return "more than " + std::to_string(max_bdf_steps) + " past states are not supported";
  std::vector<double> past_times;
  for (std::size_t r = 1; r <= l; ++r) past_times.push_back(-static_cast<double>(r));
  const BdfWeights bdf = bdf_weights(past_times, {0.0, 1.0});
  bool same = is_zero(bdf.beta - row.beta);
  for (std::size_t r = 0; r < l; ++r) same = same && is_zero(bdf.alpha()[r] - row.alpha[r]);
  if (!same) return "with several past states it must be the backward differentiation formula";
  return std::nullopt;
}

/// x^T = r^T L^-1 for the leading n x n block L of A.
std::vector<double> times_inverse(const std::vector<double>& r, const std::vector<std::vector<double>>& A,
                                  std::size_t n) {
  std::vector<double> x(n);
  for (std::size_t j = n; j-- > 0;) {
    double sum = r[j];
    for (std::size_t k = j + 1; k < n; ++k) sum -= x[k] * A[k][j];
    x[j] = sum / A[j][j];
  }
  return x;
}

/// Exactness of y_{n+1} = sum_r alpha_r y_{n+1-r} + beta dt f_{n+1} on t^k, with t_n = 0 and dt = 1.
int multistep_order(const MethodRow& row) {
  int order = 0;
  for (int k = 1; k <= max_bdf_steps; ++k) {
    double sum = row.beta * k;
    for (std::size_t r = 0; r < row.alpha.size(); ++r) sum += row.alpha[r] * std::pow(-static_cast<double>(r), k);
    if (!is_zero(sum - 1.0)) break;
    order = k;
  }
  return order;
}

/// The conditions sum b = 1; b.c = 1/2; b.c^2 = 1/3, b.A c = 1/6 (Hairer & Wanner II, IV.5).
int multistage_order(const Method& m) {
  const std::size_t s = m.b.size();
  double b = 0.0, bc = 0.0, bcc = 0.0, bAc = 0.0;
  for (std::size_t i = 0; i < s; ++i) {
    b += m.b[i];
    bc += m.b[i] * m.c[i];
    bcc += m.b[i] * m.c[i] * m.c[i];
    for (std::size_t j = 0; j <= i; ++j) bAc += m.b[i] * m.A[i][j] * m.c[j];
  }
  if (!is_zero(b - 1.0)) return 0;
  if (!is_zero(bc - 1.0 / 2.0)) return 1;
  if (!is_zero(bcc - 1.0 / 3.0) || !is_zero(bAc - 1.0 / 6.0)) return 2;
  return 3;
}

/// R(z) = 1 + z b^T (1 - z A)^-1 (1, ..., 1).
std::complex<double> stability_function(const MethodRow& row, std::complex<double> z) {
  std::vector<std::complex<double>> k(row.b.size());
  std::complex<double> R = 1.0;
  for (std::size_t i = 0; i < k.size(); ++i) {
    k[i] = 1.0;
    for (std::size_t j = 0; j < i; ++j) k[i] += z * row.A[i][j] * k[j];
    k[i] /= 1.0 - z * row.A[i][i];
    R += z * row.b[i] * k[i];
  }
  return R;
}

/// One-step methods: the poles 1/A_ii lie to the right, so |R| <= 1 on the imaginary axis suffices (maximum principle).
/// Multistep: the root locus z(zeta) = (1 - sum_r alpha_r zeta^-r) / beta of the unit circle must not enter Re z < 0.
bool is_a_stable(const MethodRow& row) {
  constexpr int num_samples = 2000;
  for (int k = 0; k < num_samples; ++k) {
    const double x = (k + 0.5) / num_samples;
    if (row.alpha.size() == 1) {
      const double y = std::pow(10.0, -4.0 + 10.0 * x);
      if (std::abs(stability_function(row, {0.0, y})) > 1.0 + tolerance) return false;
    } else {
      const auto zeta_inverse = std::polar(1.0, -std::numbers::pi * x);
      std::complex<double> z = 1.0, power = 1.0;
      for (double alpha_r : row.alpha) z -= alpha_r * (power *= zeta_inverse);
      if (z.real() < -tolerance) return false;
    }
  }
  return true;
}

/// b_i A_ij + b_j A_ji = b_i b_j (Hairer, Lubich & Wanner, Geometric Numerical Integration, VI.4).
bool is_symplectic(const MethodRow& row) {
  if (row.alpha.size() > 1) return false;
  for (std::size_t i = 0; i < row.b.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      if (!is_zero(row.b[i] * row.A[i][j] + row.b[j] * row.A[j][i] - row.b[i] * row.b[j])) return false;
    }
  }
  return true;
}

std::vector<MethodRow> rows() {
  const double gamma22 = 1.0 - std::numbers::sqrt2 / 2.0;
  const double gamma23 = 0.5 + 0.5 / std::numbers::sqrt3;
  const double g = 0.43586652150845899941601945;  // root of 6 g^3 - 18 g^2 + 9 g - 1
  const double b1 = -1.5 * g * g + 4.0 * g - 0.25, b2 = 1.5 * g * g - 5.0 * g + 1.25, c2 = 0.5 * (1.0 + g);
  // clang-format off
  return {
      {"backward-euler", {1.0}, 1.0, {{1.0}}, {1.0},
       "For setting up a model, and for robustness: it forgives most. Its strong damping belongs to the step, not to the "
       "material: motion dies away the faster the longer the step."},
      {"bdf2", {4.0 / 3.0, -1.0 / 3.0}, 2.0 / 3.0, {{1.0}}, {1.0},
       "For accuracy in most work: second order at the cost of backward-euler, damping only what the step does not resolve."},
      {"bdf3", {18.0 / 11.0, -9.0 / 11.0, 2.0 / 11.0}, 6.0 / 11.0, {{1.0}}, {1.0},
       "For smooth, well damped motion: not A-stable, lightly damped vibrations that the step hardly resolves may grow. "
       "Third order after an accurate start-up only; the ramp costs one order."},
      {"dirk22", {1.0}, 1.0, {{gamma22, 0.0}, {1.0 - gamma22, gamma22}}, {1.0 - gamma22, gamma22},
       "For second order with changing steps, or impacts: needs no past states, and damps what the step does not resolve. "
       "Two solves a step."},
      {"dirk23", {1.0}, 1.0, {{gamma23, 0.0}, {-1.0 / std::numbers::sqrt3, gamma23}}, {0.5, 0.5},
       "For third order in two solves, where nothing is very stiff: fast modes change sign and lose only a quarter of their "
       "size in a step, and the second stage starts before the step."},
      {"dirk33", {1.0}, 1.0, {{g, 0.0, 0.0}, {c2 - g, g, 0.0}, {b1, b2, g}}, {b1, b2, g},
       "For tight tolerances: third order, and damps what the step does not resolve. Three solves a step."},
      {"implicit-midpoint", {1.0}, 1.0, {{0.5}}, {1.0},
       "For long conservative motion, at a constant step: symplectic, keeps the energy of linear problems and bounds its "
       "error in others. Nothing is damped, so rough data keep ringing."},
      {"symplectic-dirk22", {1.0}, 1.0, {{0.25, 0.0}, {0.5, 0.25}}, {0.5, 0.5},
       "For long conservative motion, at a constant step: two steps of implicit-midpoint, each of half the length, in one."},
  };
  // clang-format on
}

}  // namespace

std::string to_string(Stability stability) {
  switch (stability) {
    case Stability::not_a_stable:
      return "not A-stable";
    case Stability::a_stable:
      return "A-stable";
    case Stability::l_stable:
      return "L-stable";
  }
  return "";
}

std::variant<Method, MethodRefusal> derive_method(MethodRow row) {
  for (const auto refuse : {refuse_shape, refuse_stages, refuse_inconsistency}) {
    if (const auto reason = refuse(row)) return MethodRefusal{"method '" + row.name + "' is refused: " + *reason};
  }
  Method m;
  static_cast<MethodRow&>(m) = std::move(row);
  const std::size_t s = m.b.size();
  m.num_steps = static_cast<int>(m.alpha.size());
  m.num_stages = static_cast<int>(s);
  for (const auto& A_i : m.A) m.c.push_back(std::accumulate(A_i.begin(), A_i.end(), 0.0));
  for (std::size_t i = 0; i < s; ++i) m.At.push_back(times_inverse(m.A[i], m.A, i));
  m.bt = times_inverse(m.b, m.A, s);

  m.stiffly_accurate = true;
  for (std::size_t j = 0; j < s; ++j) m.stiffly_accurate = m.stiffly_accurate && is_zero(m.A[s - 1][j] - m.b[j]);
  if (m.stiffly_accurate) {  // free of rounding, so that the last stage is the end to the last bit
    std::ranges::fill(m.bt, 0.0);
    m.bt.back() = 1.0;
    m.c.back() = 1.0;
  }
  m.order = m.num_steps > 1 ? multistep_order(m) : multistage_order(m);
  m.R_infinity = 1.0 - std::accumulate(m.bt.begin(), m.bt.end(), 0.0);
  m.symplectic = is_symplectic(m);
  if (is_a_stable(m)) {
    m.stability = m.num_steps == 1 && is_zero(m.R_infinity) ? Stability::l_stable : Stability::a_stable;
  }
  m.max_growth = bdf_max_growth(m.num_steps);
  return m;
}

std::span<const Method> methods() {
  static const std::vector<Method> table = [] {
    std::vector<Method> derived;
    for (auto& row : rows()) derived.push_back(std::get<Method>(derive_method(std::move(row))));
    return derived;
  }();
  return table;
}

const Method* find_method(std::string_view name) {
  const auto table = methods();
  const auto found = std::ranges::find(table, name, &Method::name);
  return found == table.end() ? nullptr : &*found;
}

}  // namespace pliant
