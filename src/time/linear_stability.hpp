/// How a method acts on linear motion y' = lambda y: with z = lambda dt a step multiplies modes by the roots zeta of
///
///     zeta^l = R(beta z) sum_r alpha_r zeta^(l-r),   R(z) = 1 + z b^T (1 - z A)^-1 (1, ..., 1)
///
/// (one past state: zeta = R(z)). Source: Hairer & Wanner II, IV.3 and V.1.
#pragma once

#include "time/method.hpp"

#include <complex>
#include <span>
#include <vector>

namespace pliant {

/// The l roots at z = lambda dt, Re z <= 0.
std::vector<std::complex<double>> amplification(const MethodRow& row, std::complex<double> z);

/// The root condition (zero-stability): at z = 0 no root lies outside the unit circle, and no double root on it.
bool is_zero_stable(const MethodRow& row);

/// A-stability: no mode that decays or keeps its size grows, whatever the step.
bool is_a_stable(const MethodRow& row);

/// The root of largest modulus at z = infinity, where R = 1 - sum_i bt_i; for several past states its modulus.
double damping_at_infinity(std::span<const double> alpha, std::span<const double> bt);

/// Symplecticity: b_i A_ij + b_j A_ji = b_i b_j with one past state (Hairer, Lubich & Wanner, Geometric Numerical
/// Integration, VI.4).
bool is_symplectic(const MethodRow& row);

}  // namespace pliant
