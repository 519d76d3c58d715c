/// Packs of doubles (SIMD) for the hot loops, and the vectorised functions that libc lacks.
///
/// Everything here is a pure function of its arguments and works lane by lane; a kernel written for a scalar type T
/// runs with T = double and T = Pack alike. Other floating types work too, slowly: they give the tests reference
/// values.
#pragma once

#include "base/inline.hpp"

#include <array>
#include <cmath>
#include <concepts>

#include <experimental/simd>

namespace pliant {

/// As many doubles as one register holds: 8 with AVX-512, 4 with AVX, 2 with SSE2.
using Pack = std::experimental::native_simd<double>;
inline constexpr int pack_size = static_cast<int>(Pack::size());

using std::experimental::all_of;
using std::experimental::any_of;

/// mask ? a : b, lane by lane.
PLIANT_INLINE Pack select(const Pack::mask_type& mask, const Pack& a, Pack b) {
  where(mask, b) = a;
  return b;
}
template <class T>
PLIANT_INLINE T select(bool mask, const T& a, const T& b) {
  return mask ? a : b;
}

/// The sum over the lanes.
PLIANT_INLINE double sum(const Pack& x) {
  return std::experimental::reduce(x);
}
PLIANT_INLINE double sum(double x) {
  return x;
}

/// Where x_minus_log1p uses its series: |s| <= 1/4 in s = x / (2 + x).
inline constexpr double log1p_series_lower = -0.4;
inline constexpr double log1p_series_upper = 2.0 / 3.0;

/// x - ln(1 + x) for log1p_series_lower <= x <= log1p_series_upper, to 3 ulp, also where it is x^2/2 << x.
///
/// With s = x / (2 + x), ln(1 + x) = 2 atanh(s) = 2 s + 2 s^3 (1/3 + s^2/5 + s^4/7 + ...) and x - 2 s = s x, hence
///   x - ln(1 + x) = s (x - 2 s^2 (1/3 + s^2/5 + ...)),
/// in which nothing cancels. The first of the terms left out, s^24/27, is below 4e-17 of the result.
template <class T>
PLIANT_INLINE T x_minus_log1p_series(const T& x) {
  constexpr std::array<double, 12> c{1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9,  1.0 / 11, 1.0 / 13,
                                     1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21, 1.0 / 23, 1.0 / 25};
  const T s = x / (2.0 + x);
  const T s2 = s * s;
  // Even and odd coefficients apart (in s^4): half the chain of dependent operations.
  const T s4 = s2 * s2;
  const T even = ((((c[10] * s4 + c[8]) * s4 + c[6]) * s4 + c[4]) * s4 + c[2]) * s4 + c[0];
  const T odd = ((((c[11] * s4 + c[9]) * s4 + c[7]) * s4 + c[5]) * s4 + c[3]) * s4 + c[1];
  return s * (x - 2.0 * s2 * (odd * s2 + even));
}

/// x - ln(1 + x) to 6 ulp for every x > -1; +inf at -1, NaN below.
inline double x_minus_log1p(double x) {
  if (x >= log1p_series_lower && x <= log1p_series_upper) return x_minus_log1p_series(x);
  return x - std::log1p(x);
}

/// ln(1 + x) to 2 ulp; -inf at -1, NaN below, as std::log1p.
inline double log1p(double x) {
  if (x >= log1p_series_lower && x <= log1p_series_upper) return x - x_minus_log1p_series(x);
  return std::log1p(x);
}

// Lane by lane, for a pack with a lane outside the series. Not inlined: it is rare, and would burden the loops.
[[gnu::noinline, gnu::cold]] inline Pack x_minus_log1p_by_lane(const Pack& x) {
  return Pack([&](auto i) { return x_minus_log1p(static_cast<double>(x[i])); });
}
[[gnu::noinline, gnu::cold]] inline Pack log1p_by_lane(const Pack& x) {
  return Pack([&](auto i) { return log1p(static_cast<double>(x[i])); });
}

PLIANT_INLINE Pack x_minus_log1p(const Pack& x) {
  if (all_of(x >= log1p_series_lower && x <= log1p_series_upper)) [[likely]]
    return x_minus_log1p_series(x);
  return x_minus_log1p_by_lane(x);
}

PLIANT_INLINE Pack log1p(const Pack& x) {
  if (all_of(x >= log1p_series_lower && x <= log1p_series_upper)) [[likely]]
    return x - x_minus_log1p_series(x);
  return log1p_by_lane(x);
}

/// Any other floating type: the same series, summed until it no longer changes. Slow for x far from 0; x > -1.
template <class T>
requires(!std::same_as<T, double> && !std::same_as<T, Pack>) T x_minus_log1p(const T& x) {
  const T s = x / (2 + x);
  T power = 1;
  T tail = 0;
  for (int n = 3;; n += 2) {
    const T next = tail + power / n;
    if (next == tail) break;
    tail = next;
    power *= s * s;
  }
  return s * (x - 2 * s * s * tail);
}
template <class T>
requires(!std::same_as<T, double> && !std::same_as<T, Pack>) T log1p(const T& x) {
  return x - x_minus_log1p(x);
}

}  // namespace pliant
