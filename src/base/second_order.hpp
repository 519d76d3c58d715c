/// Numbers with their first, and second, derivatives by N variables (forward-mode automatic differentiation).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace pliant {

/// f, grad f and, of order 2, the symmetric Hessian of f. A constant has no derivatives; `variable` makes the others.
template <std::size_t N, int order>
struct Differentiated {
  static_assert(order == 1 || order == 2);
  static constexpr bool has_bend = order == 2;

  double value = 0.0;
  std::array<double, N> slope{};
  std::array<double, has_bend ? N*(N + 1) / 2 : 0> bend{};  ///< of i >= j at i (i + 1) / 2 + j

  Differentiated() = default;
  Differentiated(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): a number is a constant
  static Differentiated variable(double value, std::size_t number) {
    Differentiated x(value);
    x.slope[number] = 1.0;
    return x;
  }
  double bend_of(std::size_t i, std::size_t j) const {
    return i >= j ? bend[i * (i + 1) / 2 + j] : bend[j * (j + 1) / 2 + i];
  }
  /// For i >= j.
  double& bend_at(std::size_t i, std::size_t j) { return bend[i * (i + 1) / 2 + j]; }

  /// f(x) with f, f' and f'' at the value of x.
  Differentiated mapped(double f, double f1, double f2) const {
    Differentiated result(f);
    for (std::size_t i = 0; i < N; ++i) result.slope[i] = f1 * slope[i];
    result.bend_by(
        [&](std::size_t k, std::size_t i, std::size_t j) { return f1 * bend[k] + f2 * slope[i] * slope[j]; });
    return result;
  }
  Differentiated& add(double factor, const Differentiated& x) {
    value += factor * x.value;
    for (std::size_t i = 0; i < N; ++i) slope[i] += factor * x.slope[i];
    for (std::size_t k = 0; k < bend.size(); ++k) bend[k] += factor * x.bend[k];
    return *this;
  }

  friend Differentiated operator+(Differentiated x, const Differentiated& y) { return x.add(1.0, y); }
  friend Differentiated operator-(Differentiated x, const Differentiated& y) { return x.add(-1.0, y); }
  friend Differentiated operator*(const Differentiated& x, const Differentiated& y) {
    Differentiated result(x.value * y.value);
    for (std::size_t i = 0; i < N; ++i) result.slope[i] = x.value * y.slope[i] + y.value * x.slope[i];
    result.bend_by([&](std::size_t k, std::size_t i, std::size_t j) {
      return x.value * y.bend[k] + y.value * x.bend[k] + x.slope[i] * y.slope[j] + x.slope[j] * y.slope[i];
    });
    return result;
  }
  friend Differentiated operator*(double s, Differentiated x) {
    x.value *= s;
    for (double& d : x.slope) d *= s;
    for (double& d : x.bend) d *= s;
    return x;
  }
  friend Differentiated operator/(const Differentiated& x, const Differentiated& y) {
    const double inverse = 1.0 / y.value;
    return x * y.mapped(inverse, -inverse * inverse, 2.0 * inverse * inverse * inverse);
  }
  friend Differentiated sqrt(const Differentiated& x) {
    const double root = std::sqrt(x.value);
    return x.mapped(root, 0.5 / root, -0.25 / (root * x.value));
  }
  /// The derivatives are those of asin(y / r) with r^2 = x^2 + y^2, in a form without singularities but r = 0.
  friend Differentiated atan2(const Differentiated& y, const Differentiated& x) {
    const double square = x.value * x.value + y.value * y.value;
    const double fx = -y.value / square, fy = x.value / square;
    const double fxx = -2.0 * fx * fy, fxy = fx * fx - fy * fy;  // f_yy = -f_xx
    Differentiated result(std::atan2(y.value, x.value));
    for (std::size_t i = 0; i < N; ++i) result.slope[i] = fx * x.slope[i] + fy * y.slope[i];
    result.bend_by([&](std::size_t k, std::size_t i, std::size_t j) {
      return fx * x.bend[k] + fy * y.bend[k] + fxx * (x.slope[i] * x.slope[j] - y.slope[i] * y.slope[j]) +
             fxy * (x.slope[i] * y.slope[j] + y.slope[i] * x.slope[j]);
    });
    return result;
  }

 private:
  /// Sets the second derivatives, if there are any: bend[k] = entry(k, i, j).
  template <class Entry>
  void bend_by(const Entry& entry) {
    if constexpr (has_bend) {
      for (std::size_t i = 0, k = 0; i < N; ++i) {
        for (std::size_t j = 0; j <= i; ++j, ++k) bend[k] = entry(k, i, j);
      }
    }
  }
};

template <std::size_t N>
using SecondOrder = Differentiated<N, 2>;

}  // namespace pliant
