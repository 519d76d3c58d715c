#include "time/linear_stability.hpp"

#include "time/order_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant {
namespace {

using Complex = std::complex<double>;

/// R(z)
Complex stability_function(const MethodRow& row, Complex z) {
  std::vector<Complex> k(row.b.size());
  Complex R = 1.0;
  for (std::size_t i = 0; i < k.size(); ++i) {
    k[i] = 1.0;
    for (std::size_t j = 0; j < i; ++j) k[i] += z * row.A[i][j] * k[j];
    k[i] /= 1.0 - z * row.A[i][i];
    R += z * row.b[i] * k[i];
  }
  return R;
}

/// Roots of zeta^l = R sum_r alpha_r zeta^(l-r), all at once (Weierstrass, Durand, Kerner). Simple ones to rounding, of
/// double ones half the digits.
std::vector<Complex> roots(std::span<const double> alpha, Complex R) {
  const std::size_t l = alpha.size();
  if (l == 1) return {R * alpha[0]};
  const auto value = [&](Complex zeta) {
    Complex p = 1.0;
    for (double alpha_r : alpha) p = p * zeta - R * alpha_r;
    return p;
  };
  std::vector<Complex> zeta;
  for (std::size_t k = 0; k < l; ++k) zeta.push_back(std::pow(Complex(0.4, 0.9), static_cast<int>(k)));
  constexpr int max_iterations = 500;
  double change = 1.0;
  for (int iteration = 0; iteration < max_iterations && change > 1e-14; ++iteration) {
    change = 0.0;
    for (std::size_t k = 0; k < l; ++k) {
      Complex step = value(zeta[k]);
      for (std::size_t m = 0; m < l; ++m) {
        if (m != k) step /= zeta[k] - zeta[m];
      }
      if (!std::isfinite(std::abs(step))) continue;  // two approximations met
      zeta[k] -= step;
      change = std::max(change, std::abs(step));
    }
  }
  return zeta;
}

double largest_modulus(const std::vector<Complex>& zeta) {
  double largest = 0.0;
  for (const Complex& root : zeta) largest = std::max(largest, std::abs(root));
  return largest;
}

}  // namespace

std::vector<Complex> amplification(const MethodRow& row, Complex z) {
  return roots(row.alpha, stability_function(row, row.beta * z));
}

bool is_zero_stable(const MethodRow& row) {
  constexpr double same_place = 1e-4;  // beyond the error of double and triple roots
  const std::vector<Complex> zeta = roots(row.alpha, 1.0);
  for (std::size_t k = 0; k < zeta.size(); ++k) {
    if (std::abs(zeta[k]) > 1.0 + 1e-7) return false;
    for (std::size_t m = 0; m < k; ++m) {
      if (std::abs(zeta[k] - zeta[m]) < same_place && std::abs(zeta[k]) > 1.0 - same_place) return false;
    }
  }
  return true;
}

// The poles 1/(beta A_ii) lie to the right, so the roots are bounded on the left, and there their largest modulus is a
// subharmonic function: it is enough to look at the imaginary axis (maximum principle).
bool is_a_stable(const MethodRow& row) {
  constexpr int num_samples = 2000;
  for (int k = 0; k < num_samples; ++k) {
    const double y = std::pow(10.0, -4.0 + 10.0 * (k + 0.5) / num_samples);
    if (largest_modulus(amplification(row, {0.0, y})) > 1.0 + coefficient_tolerance) return false;
  }
  return true;
}

double damping_at_infinity(std::span<const double> alpha, std::span<const double> bt) {
  const double R = 1.0 - std::accumulate(bt.begin(), bt.end(), 0.0);
  if (alpha.size() == 1) return R;
  return std::abs(R) < coefficient_tolerance ? 0.0 : largest_modulus(roots(alpha, R));
}

bool is_symplectic(const MethodRow& row) {
  if (row.alpha.size() > 1) return false;
  for (std::size_t i = 0; i < row.b.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const double defect = row.b[i] * row.A[i][j] + row.b[j] * row.A[j][i] - row.b[i] * row.b[j];
      if (std::abs(defect) > coefficient_tolerance) return false;
    }
  }
  return true;
}

}  // namespace pliant
