/// Numbers of twice a double's digits, and the functions that textbook energies need of them.
#pragma once

#include "base/tensor.hpp"

#include <array>
#include <cmath>

namespace pliant::testing_states {

/// Differences and textbook formulas in it count as exact.
__extension__ typedef __float128 Quad;

/// 2 atanh(s) = ln((1 + s) / (1 - s)) by its power series.
inline Quad twice_atanh(Quad s) {
  Quad sum = 0;
  Quad power = 2 * s;
  for (int n = 1; n < 200; n += 2) {
    const Quad next = sum + power / n;
    if (next == sum) break;
    sum = next;
    power *= s * s;
  }
  return sum;
}

/// ln x, halved or doubled into (0.7, 1.4) first.
inline Quad log_reference(Quad x) {
  static const Quad log_2 = twice_atanh(Quad(1) / 3);
  int doublings = 0;
  for (; x > 1.4; x /= 2) ++doublings;
  for (; x < 0.7; x *= 2) --doublings;
  return doublings * log_2 + twice_atanh((x - 1) / (x + 1));
}

/// exp x by its power series, after halvings.
inline Quad exp_reference(Quad x) {
  int halvings = 0;
  for (; x > 0.1 || x < -0.1; x /= 2) ++halvings;
  Quad sum = 1, power = 1;
  for (int n = 1; n < 40; ++n) {
    power *= x / n;
    if (sum + power == sum) break;
    sum += power;
  }
  for (; halvings > 0; --halvings) sum *= sum;
  return sum;
}

inline Quad power_reference(Quad x, Quad exponent) {
  return exp_reference(exponent * log_reference(x));
}

/// Newton's method from the double's root.
inline Quad root_reference(Quad x) {
  Quad root = std::sqrt(static_cast<double>(x));
  if (root == 0) return root;
  for (int n = 0; n < 2; ++n) root = (root + x / root) / 2;
  return root;
}

/// Of a symmetric tensor, in no order, by Jacobi rotations.
inline std::array<Quad, 3> eigenvalues_reference(Tensor3<Quad> A) {
  const auto off = [&] { return A(0, 1) * A(0, 1) + A(0, 2) * A(0, 2) + A(1, 2) * A(1, 2); };
  for (int n = 0; n < 30 && off() > 1e-70 * dot(A, A); ++n) {
    const int r = n % 3, p = (r + 1) % 3, q = (r + 2) % 3;
    if (A(p, q) == 0) continue;
    const Quad theta = (A(q, q) - A(p, p)) / (2 * A(p, q)), root = root_reference(1 + theta * theta);
    const Quad t = theta < 0 ? 1 / (theta - root) : 1 / (theta + root);
    const Quad c = 1 / root_reference(1 + t * t), s = t * c;
    A(p, p) -= t * A(p, q);
    A(q, q) += t * A(p, q);
    A(p, q) = A(q, p) = 0;
    const Quad rp = A(r, p), rq = A(r, q);
    A(r, p) = A(p, r) = c * rp - s * rq;
    A(r, q) = A(q, r) = s * rp + c * rq;
  }
  return {A(0, 0), A(1, 1), A(2, 2)};
}

}  // namespace pliant::testing_states
