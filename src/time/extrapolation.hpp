/// Polynomials through values at past times, continued.
#pragma once

#include <cstddef>
#include <span>

namespace pliant {

/// How many of the values a polynomial should pass through that is continued to `time`: one that continues for more
/// than twice their mean distance says little. `times`: of the values, newest first, at least one.
inline std::size_t num_extrapolated(std::span<const double> times, double time) {
  constexpr double longest = 2.0;
  std::size_t n = times.size();
  while (n > 1 && time - times[0] > longest * (times[0] - times[n - 1]) / static_cast<double>(n - 1)) --n;
  return n;
}

/// The weight of the value `r` in the polynomial through all of them, at `time` (Lagrange).
inline double extrapolation_weight(std::span<const double> times, std::size_t r, double time) {
  double weight = 1.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (k != r) weight *= (time - times[k]) / (times[r] - times[k]);
  }
  return weight;
}

}  // namespace pliant
