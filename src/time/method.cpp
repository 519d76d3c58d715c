#include "time/method.hpp"

#include "base/text.hpp"
#include "time/bdf.hpp"
#include "time/linear_stability.hpp"
#include "time/order_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pliant {
namespace {

std::string row_number(std::size_t i) {
  return std::to_string(i + 1);
}

bool is_close(double a, double b) {
  return std::abs(a - b) < coefficient_tolerance;
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
  if (row.alpha.size() > max_past_states) {
    return "it has " + std::to_string(row.alpha.size()) + " past states, and at most " +
           std::to_string(max_past_states) + " are kept";
  }
  if (s > max_stages) {
    return "it has " + std::to_string(s) + " stages, and at most " + std::to_string(max_stages) + " are supported";
  }
  if (row.alpha.back() == 0.0) return "alpha ends in a zero: leave it out";
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

// Stricter than the orders: what is missing here is missing from a body at rest in every step.
std::optional<std::string> refuse_inconsistency(const MethodRow& row) {
  constexpr double tolerance = 1e-12;
  double sum_alpha = 0.0, lag = 0.0;
  for (std::size_t r = 0; r < row.alpha.size(); ++r) {
    sum_alpha += row.alpha[r];
    lag += static_cast<double>(r) * row.alpha[r];
  }
  const double sum_b = std::accumulate(row.b.begin(), row.b.end(), 0.0);
  const auto differs = [](double a, double b) { return std::abs(a - b) > tolerance; };
  if (differs(sum_alpha, 1.0)) {
    return "it is inconsistent: alpha sums to " + format_number(sum_alpha) + " instead of 1";
  }
  if (differs(sum_b, 1.0)) return "it is inconsistent: b sums to " + format_number(sum_b) + " instead of 1";
  if (differs(row.beta, 1.0 + lag)) {
    return "it is inconsistent: with this alpha, beta must be " + format_number(1.0 + lag);
  }
  return std::nullopt;
}

std::optional<std::string> refuse_instability(const MethodRow& row) {
  if (is_zero_stable(row)) return std::nullopt;
  return "it is not zero-stable: errors grow from step to step, the faster the shorter the steps (a root of zeta^l = "
         "sum_r alpha_r zeta^(l-r) lies outside the unit circle, or a double one on it)";
}

static_assert(max_past_states <= max_bdf_steps);

/// Whether the row is the backward differentiation formula of its past states, whose form for changing steps is known.
bool is_bdf(const MethodRow& row) {
  if (row.b.size() > 1 || !is_close(row.A[0][0], 1.0)) return false;
  const std::size_t l = row.alpha.size();
  std::vector<double> past_times;
  for (std::size_t r = 1; r <= l; ++r) past_times.push_back(-static_cast<double>(r));
  const BdfWeights bdf = bdf_weights(past_times, {0.0, 1.0});
  return is_close(bdf.beta, row.beta) && std::ranges::equal(bdf.alpha(), row.alpha, is_close);
}

void set_weights(Method& m) {
  const std::size_t s = m.b.size();
  for (const auto& A_i : m.A) m.c.push_back(std::accumulate(A_i.begin(), A_i.end(), 0.0));
  for (std::size_t i = 0; i < s; ++i) m.At.push_back(times_inverse(std::span(m.A[i]).first(i), m.A));
  m.bt = times_inverse(m.b, m.A);
  m.stiffly_accurate = std::ranges::equal(m.A[s - 1], m.b, is_close);
  if (m.stiffly_accurate) {  // free of rounding, so that the last stage is the end to the last bit
    std::ranges::fill(m.bt, 0.0);
    m.bt.back() = 1.0;
    m.c.back() = 1.0;
  }
}

/// Reason for symplectic methods, which run at a constant step.
void set_embedded(Method& m) {
  if (m.symplectic) return;
  if (auto embedded = embedded_formula(m)) {
    m.bt_embedded = std::move(embedded->bt);
    m.embedded_order = embedded->order;
    m.embedded_error = embedded->error;
  }
}

std::vector<MethodRow> method_rows() {
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
  for (const auto refuse : {refuse_shape, refuse_stages, refuse_inconsistency, refuse_instability}) {
    if (const auto reason = refuse(row)) return MethodRefusal{"method '" + row.name + "' is refused: " + *reason};
  }
  Method m;
  static_cast<MethodRow&>(m) = std::move(row);
  m.num_steps = static_cast<int>(m.alpha.size());
  m.num_stages = static_cast<int>(m.b.size());
  set_weights(m);
  m.order = convergence_order(m);
  m.reconstructed_rate_order = reconstructed_rate_order(m);
  m.R_infinity = damping_at_infinity(m.alpha, m.bt);
  m.symplectic = is_symplectic(m);
  if (is_a_stable(m)) {
    m.stability = m.num_steps == 1 && is_close(m.R_infinity, 0.0) ? Stability::l_stable : Stability::a_stable;
  }
  m.needs_equal_steps = m.num_steps > 1 && !(is_bdf(m) && has_known_growth(m.num_steps));
  m.max_growth = m.needs_equal_steps ? 1.0 : bdf_max_growth(m.num_steps);
  m.error_constant = error_constant(m, m.order);
  set_embedded(m);
  return m;
}

std::optional<std::string> why_not_adaptive(const Method& method) {
  if (method.symplectic) {
    return "method '" + method.name + "' is symplectic, and keeps this property only at a constant step";
  }
  if (method.needs_equal_steps) {
    return "method '" + method.name + "' needs equal steps: its coefficients for variable steps are not known";
  }
  if (method.stiffly_accurate || !method.bt_embedded.empty()) return std::nullopt;
  return "method '" + method.name + "' has too few stages for an embedded formula that estimates its error";
}

bool keeps_order_with_reconstructed_rates(const Method& method) {
  return method.reconstructed_rate_order == method.order;
}

int estimate_order(const Method& method) {
  return method.stiffly_accurate ? method.order : method.embedded_order + 1;
}

std::span<const Method> methods() {
  static const std::vector<Method> table = [] {
    std::vector<Method> derived;
    for (auto& row : method_rows()) derived.push_back(std::get<Method>(derive_method(std::move(row))));
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
