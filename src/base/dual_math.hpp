/// Quotients, comparisons and functions of dual numbers (base/dual.hpp), so that code written for a scalar type T runs
/// with T = Dual<double> too. Comparisons decide which branch a value takes and look at it alone; only != looks at the
/// slope as well, because a number that is about to leave 0 is not negligible.
#pragma once

#include "base/dual.hpp"
#include "base/vector_math.hpp"

#include <cmath>
#include <type_traits>

namespace pliant {

template <class T>
Dual<T> operator/(const Dual<T>& x, const Dual<T>& y) {
  const T quotient = x.value / y.value;
  return {quotient, (x.slope - quotient * y.slope) / y.value};
}
template <class T>
Dual<T> operator/(double x, const Dual<T>& y) {
  return Dual<T>(x) / y;
}
template <class T>
Dual<T> operator/(const Dual<T>& x, double y) {
  return {x.value / y, x.slope / y};
}

template <class T>
Dual<T>& operator+=(Dual<T>& x, const std::type_identity_t<Dual<T>>& y) {
  return x = x + y;
}
template <class T>
Dual<T>& operator-=(Dual<T>& x, const std::type_identity_t<Dual<T>>& y) {
  return x = x - y;
}
template <class T>
Dual<T>& operator*=(Dual<T>& x, const std::type_identity_t<Dual<T>>& y) {
  return x = x * y;
}

template <class T>
bool operator<(const Dual<T>& x, const Dual<T>& y) {
  return x.value < y.value;
}
template <class T>
bool operator<(const Dual<T>& x, double y) {
  return x.value < y;
}
template <class T>
bool operator>(const Dual<T>& x, const Dual<T>& y) {
  return y < x;
}
template <class T>
bool operator>(const Dual<T>& x, double y) {
  return x.value > y;
}
template <class T>
bool operator==(const Dual<T>& x, double y) {
  return x.value == y;
}
template <class T>
bool operator!=(const Dual<T>& x, double y) {
  return x.value != y || x.slope != T(0.0);
}

template <class T>
Dual<T> exp(const Dual<T>& x) {
  const T power = exp(x.value);
  return {power, power * x.slope};
}
template <class T>
Dual<T> expm1(const Dual<T>& x) {
  return {expm1(x.value), exp(x.value) * x.slope};
}
template <class T>
Dual<T> log1p(const Dual<T>& x) {
  return {log1p(x.value), x.slope / (1.0 + x.value)};
}
template <class T>
Dual<T> x_minus_log1p(const Dual<T>& x) {
  return {x_minus_log1p(x.value), x.slope * x.value / (1.0 + x.value)};
}
/// The root of a constant 0 has no slope.
template <class T>
Dual<T> sqrt(const Dual<T>& x) {
  const T root = sqrt(x.value);
  return {root, x.slope == T(0.0) ? T(0.0) : T(x.slope / (2.0 * root))};
}

/// phi1' = phi1 - phi2.
template <class T>
Dual<T> phi1(const Dual<T>& x) {
  const T value = phi1(x.value);
  return {value, (value - phi2(x.value)) * x.slope};
}

}  // namespace pliant
