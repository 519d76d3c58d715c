/// The formula of every method with its slopes, as it stands in books, on one degree of freedom: what the derived
/// numbers of a method are measured with, independently of the weights At and bt and of the stepper.
#pragma once

#include "time/method.hpp"

#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test {

/// A method made of coefficients alone.
inline Method method_of(std::vector<double> alpha, double beta, std::vector<std::vector<double>> A,
                        std::vector<double> b) {
  auto result = derive_method({"own", std::move(alpha), beta, std::move(A), std::move(b), ""});
  if (const auto* refused = std::get_if<MethodRefusal>(&result)) throw std::invalid_argument(refused->reason);
  return std::get<Method>(std::move(result));
}

/// Rows that nobody ships, by what they are.
struct OwnMethod {
  std::string what;
  Method method;
};

inline std::vector<OwnMethod> own_methods() {
  const double a = std::cos(M_PI / 18) / std::sqrt(3.0) + 0.5, q = 1 / (6 * (2 * a - 1) * (2 * a - 1));
  const double g = (3 - std::sqrt(3.0)) / 6, d = std::sqrt(175.0 / 192), h = (11.0 / 8 + d) / 2;
  return {
      {"Norsett's of order 4",
       method_of({1}, 1, {{a, 0, 0}, {0.5 - a, a, 0}, {2 * a, 1 - 4 * a, a}}, {q, 1 - 2 * q, q})},
      {"the other two-stage one of order 3", method_of({1}, 1, {{g, 0}, {1 - 2 * g, g}}, {0.5, 0.5})},
      {"a theta method", method_of({1}, 1, {{0.7}}, {1})},
      {"three stages of order 1", method_of({1}, 1, {{0.5, 0, 0}, {0.2, 0.4, 0}, {0.1, 0.3, 0.5}}, {0.2, 0.3, 0.5})},
      {"two steps of order 1", method_of({0.5, 0.5}, 1.5, {{1}}, {1})},
      {"two steps of order 2, not BDF", method_of({1.2, -0.2}, 0.8, {{0.6875}}, {1})},
      {"two steps, two stages, order 3", method_of({1.2, -0.2}, 0.8, {{h, 0}, {2 * d / 7, h}}, {2.75, -1.75})},
      {"BDF of four steps", method_of({48. / 25, -36. / 25, 16. / 25, -3. / 25}, 12. / 25, {{1}}, {1})},
  };
}

inline std::vector<OwnMethod> all_methods() {
  std::vector<OwnMethod> all = own_methods();
  for (const Method& m : methods()) all.push_back({m.name, m});
  return all;
}

/// y_{n+1} of y' = lambda y with dt = 1, from y_n, y_{n-1}, ...; `increments` becomes Y_i - y*.
inline std::complex<double> linear_step(const MethodRow& row, std::complex<double> lambda,
                                        const std::vector<std::complex<double>>& past,
                                        std::vector<std::complex<double>>& increments) {
  std::complex<double> base = 0.0;
  for (std::size_t r = 0; r < past.size(); ++r) base += row.alpha[r] * past[r];
  std::vector<std::complex<double>> slopes;
  std::complex<double> end = base;
  increments.clear();
  for (std::size_t i = 0; i < row.b.size(); ++i) {
    std::complex<double> start = base;
    for (std::size_t j = 0; j < i; ++j) start += row.beta * row.A[i][j] * slopes[j];
    const std::complex<double> stage = start / (1.0 - row.beta * row.A[i][i] * lambda);
    slopes.push_back(lambda * stage);
    increments.push_back(stage - base);
    end += row.beta * row.b[i] * slopes[i];
  }
  return end;
}

/// How the rate of E(q) is found in a stage.
enum class Rate { exact, reconstructed };

/// q'' = -sin q - (0.3 + 0.15 q) E'(q) dE/dt + g(t) with E = q + q^2 + q^3/3, g such that q = 0.5 + sin 1.3 t. Largest
/// error of v over two units of time, from exact past states.
inline double error_of_viscous_motion(const MethodRow& row, Rate rate, int num_steps) {
  const auto q_exact = [](double t) { return 0.5 + std::sin(1.3 * t); };
  const auto v_exact = [](double t) { return 1.3 * std::cos(1.3 * t); };
  const auto E = [](double q) { return q + q * q + q * q * q / 3; };
  const auto dE = [](double q) { return (1 + q) * (1 + q); };
  const auto force = [&](double q, double E_rate) { return -std::sin(q) - (0.3 + 0.15 * q) * dE(q) * E_rate; };
  const auto g = [&](double t) { return -1.69 * std::sin(1.3 * t) - force(q_exact(t), dE(q_exact(t)) * v_exact(t)); };
  const double dt = 2.0 / num_steps;
  const std::size_t l = row.alpha.size(), s = row.b.size();
  std::vector<double> q, v;  // newest first
  for (std::size_t r = 0; r < l; ++r) {
    q.push_back(q_exact(-static_cast<double>(r) * dt));
    v.push_back(v_exact(-static_cast<double>(r) * dt));
  }
  double error = 0.0;
  for (int n = 0; n < num_steps; ++n) {
    double q_base = 0, v_base = 0, E_base = 0;
    for (std::size_t r = 0; r < l; ++r) {
      q_base += row.alpha[r] * q[r];
      v_base += row.alpha[r] * v[r];
      E_base += row.alpha[r] * E(q[r]);
    }
    std::vector<double> q_slopes(s), v_slopes(s), E_slopes(s);
    double q_end = q_base, v_end = v_base;
    for (std::size_t i = 0; i < s; ++i) {
      double q_0 = q_base, v_0 = v_base, E_0 = E_base, c = 0;
      for (std::size_t j = 0; j <= i; ++j) c += row.A[i][j];
      for (std::size_t j = 0; j < i; ++j) {
        q_0 += row.beta * dt * row.A[i][j] * q_slopes[j];
        v_0 += row.beta * dt * row.A[i][j] * v_slopes[j];
        E_0 += row.beta * dt * row.A[i][j] * E_slopes[j];
      }
      const double dt_i = row.beta * row.A[i][i] * dt, t_i = (n + 1 - row.beta + row.beta * c) * dt;
      double q_i = q_0 + dt_i * v_0;
      const auto residual = [&](double x) {
        q_slopes[i] = (x - q_0) / dt_i;
        v_slopes[i] = (q_slopes[i] - v_0) / dt_i;
        E_slopes[i] = rate == Rate::exact ? dE(x) * q_slopes[i] : (E(x) - E_0) / dt_i;
        return dt_i * dt_i * (v_slopes[i] - force(x, E_slopes[i]) - g(t_i));
      };
      for (int k = 0; k < 8; ++k) {
        const double h = 1e-6;
        q_i -= residual(q_i) * 2 * h / (residual(q_i + h) - residual(q_i - h));
      }
      residual(q_i);
      q_end += row.beta * dt * row.b[i] * q_slopes[i];
      v_end += row.beta * dt * row.b[i] * v_slopes[i];
    }
    q.insert(q.begin(), q_end);
    v.insert(v.begin(), v_end);
    q.pop_back();
    v.pop_back();
    error = std::max(error, std::abs(v_end - v_exact((n + 1) * dt)));
  }
  return error;
}

}  // namespace pliant::test
