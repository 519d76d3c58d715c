/// Dual numbers a + b eps with eps^2 = 0 (forward-mode automatic differentiation). A function evaluated at x + dx eps
/// gives f(x) + f'(x) dx eps: derivatives to rounding, without finite differences and without separate formulas. They
/// nest: Dual<Dual<double>> differentiates twice.
#pragma once

#include <concepts>

namespace pliant {

template <class T>
struct Dual {
  T value{};  ///< a
  T slope{};  ///< b

  constexpr Dual() = default;
  /// A constant.
  template <class S>
  requires std::convertible_to<S, T>
  constexpr Dual(const S& constant) : value(constant) {}
  constexpr Dual(const T& a, const T& b) : value(a), slope(b) {}

  friend constexpr Dual operator+(const Dual& x, const Dual& y) { return {x.value + y.value, x.slope + y.slope}; }
  friend constexpr Dual operator-(const Dual& x, const Dual& y) { return {x.value - y.value, x.slope - y.slope}; }
  friend constexpr Dual operator-(const Dual& x) { return {-x.value, -x.slope}; }
  friend constexpr Dual operator*(const Dual& x, const Dual& y) {
    return {x.value * y.value, x.value * y.slope + x.slope * y.value};
  }
  friend constexpr Dual operator*(double s, const Dual& x) { return {s * x.value, s * x.slope}; }
};

}  // namespace pliant
