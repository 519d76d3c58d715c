/// Jacobi's elliptic functions by the arithmetic-geometric mean (Abramowitz & Stegun 16.4, 17.6).
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

namespace pliant::test {

struct Jacobi {
  double sn = 0.0, cn = 1.0, dn = 1.0;
};

/// a_n and c_n of the mean of 1 and sqrt(1 - m), to rounding.
struct ArithmeticGeometricMean {
  explicit ArithmeticGeometricMean(double m) : a{1.0}, c{std::sqrt(m)} {
    for (double b = std::sqrt(1.0 - m); std::abs(c.back()) > 1e-16;) {
      const double a_n = a.back();
      a.push_back(0.5 * (a_n + b));
      c.push_back(0.5 * (a_n - b));
      b = std::sqrt(a_n * b);
    }
  }
  std::vector<double> a, c;
};

/// sn, cn, dn of u at the parameter m, 0 <= m < 1.
inline Jacobi jacobi(double u, double m) {
  const ArithmeticGeometricMean mean(m);
  const std::size_t N = mean.a.size() - 1;
  double phi = std::ldexp(mean.a[N] * u, static_cast<int>(N));
  for (std::size_t n = N; n > 0; --n) phi = 0.5 * (phi + std::asin(mean.c[n] / mean.a[n] * std::sin(phi)));
  return {std::sin(phi), std::cos(phi), std::sqrt(1.0 - m * std::sin(phi) * std::sin(phi))};
}

/// The quarter period K(m).
inline double quarter_period(double m) {
  return std::numbers::pi / (2.0 * ArithmeticGeometricMean(m).a.back());
}

}  // namespace pliant::test
