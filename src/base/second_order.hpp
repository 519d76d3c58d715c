/// Numbers with their first and second derivatives by N variables (forward-mode automatic differentiation).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace pliant {

/// f, grad f and the symmetric Hessian of f. A constant has no derivatives; `variable` makes the others.
template <std::size_t N>
struct SecondOrder {
  double value = 0.0;
  std::array<double, N> slope{};
  std::array<double, N*(N + 1) / 2> bend{};  ///< of i >= j at i (i + 1) / 2 + j

  SecondOrder() = default;
  SecondOrder(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): a number is a constant
  static SecondOrder variable(double value, std::size_t number) {
    SecondOrder x(value);
    x.slope[number] = 1.0;
    return x;
  }
  double bend_of(std::size_t i, std::size_t j) const {
    return i >= j ? bend[i * (i + 1) / 2 + j] : bend[j * (j + 1) / 2 + i];
  }

  /// f(x) with f, f' and f'' at the value of x.
  SecondOrder mapped(double f, double f1, double f2) const {
    SecondOrder result(f);
    for (std::size_t i = 0, k = 0; i < N; ++i) {
      result.slope[i] = f1 * slope[i];
      for (std::size_t j = 0; j <= i; ++j, ++k) result.bend[k] = f1 * bend[k] + f2 * slope[i] * slope[j];
    }
    return result;
  }
  SecondOrder& add(double factor, const SecondOrder& x) {
    value += factor * x.value;
    for (std::size_t i = 0; i < N; ++i) slope[i] += factor * x.slope[i];
    for (std::size_t k = 0; k < bend.size(); ++k) bend[k] += factor * x.bend[k];
    return *this;
  }

  friend SecondOrder operator+(SecondOrder x, const SecondOrder& y) { return x.add(1.0, y); }
  friend SecondOrder operator-(SecondOrder x, const SecondOrder& y) { return x.add(-1.0, y); }
  friend SecondOrder operator*(const SecondOrder& x, const SecondOrder& y) {
    SecondOrder result(x.value * y.value);
    for (std::size_t i = 0, k = 0; i < N; ++i) {
      result.slope[i] = x.value * y.slope[i] + y.value * x.slope[i];
      for (std::size_t j = 0; j <= i; ++j, ++k) {
        result.bend[k] = x.value * y.bend[k] + y.value * x.bend[k] + x.slope[i] * y.slope[j] + x.slope[j] * y.slope[i];
      }
    }
    return result;
  }
  friend SecondOrder operator*(double s, const SecondOrder& x) { return x.mapped(s * x.value, s, 0.0); }
  friend SecondOrder operator/(const SecondOrder& x, const SecondOrder& y) {
    const double inverse = 1.0 / y.value;
    return x * y.mapped(inverse, -inverse * inverse, 2.0 * inverse * inverse * inverse);
  }
  friend SecondOrder sqrt(const SecondOrder& x) {
    const double root = std::sqrt(x.value);
    return x.mapped(root, 0.5 / root, -0.25 / (root * x.value));
  }
  /// The derivatives are those of asin(y / r) with r^2 = x^2 + y^2, in a form without singularities but r = 0.
  friend SecondOrder atan2(const SecondOrder& y, const SecondOrder& x) {
    const double square = x.value * x.value + y.value * y.value;
    const double fx = -y.value / square, fy = x.value / square;
    const double fxx = -2.0 * fx * fy, fxy = fx * fx - fy * fy;  // f_yy = -f_xx
    SecondOrder result(std::atan2(y.value, x.value));
    for (std::size_t i = 0, k = 0; i < N; ++i) {
      result.slope[i] = fx * x.slope[i] + fy * y.slope[i];
      for (std::size_t j = 0; j <= i; ++j, ++k) {
        result.bend[k] = fx * x.bend[k] + fy * y.bend[k] + fxx * (x.slope[i] * x.slope[j] - y.slope[i] * y.slope[j]) +
                         fxy * (x.slope[i] * y.slope[j] + y.slope[i] * x.slope[j]);
      }
    }
    return result;
  }
};

}  // namespace pliant
