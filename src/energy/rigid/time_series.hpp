/// A value that depends on time with its first two derivatives: automatic differentiation of the second order.
#pragma once

#include <concepts>

namespace pliant {

/// x(t0 + s) = value + rate s + acceleration s^2 / 2 + ...
template <class T>
struct TimeSeries {
  T value{}, rate{}, acceleration{};

  constexpr TimeSeries() = default;
  /// A constant.
  template <class S>
  requires std::convertible_to<S, T>
  constexpr TimeSeries(const S& constant) : value(constant) {}
  constexpr TimeSeries(const T& x, const T& v, const T& a) : value(x), rate(v), acceleration(a) {}

  friend constexpr TimeSeries operator+(const TimeSeries& x, const TimeSeries& y) {
    return {x.value + y.value, x.rate + y.rate, x.acceleration + y.acceleration};
  }
  friend constexpr TimeSeries operator-(const TimeSeries& x, const TimeSeries& y) {
    return {x.value - y.value, x.rate - y.rate, x.acceleration - y.acceleration};
  }
  friend constexpr TimeSeries operator*(double s, const TimeSeries& x) {
    return {s * x.value, s * x.rate, s * x.acceleration};
  }
  friend constexpr TimeSeries operator*(const TimeSeries& x, const TimeSeries& y) {
    return {x.value * y.value, x.value * y.rate + x.rate * y.value,
            x.value * y.acceleration + T(2.0) * (x.rate * y.rate) + x.acceleration * y.value};
  }
};

}  // namespace pliant
