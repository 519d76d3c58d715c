/// States of deformation and reference values for the tests of the laws.
#pragma once

#include "material/lame.hpp"
#include "material/registry.hpp"

#include <cmath>
#include <random>
#include <string>
#include <variant>

#include <gtest/gtest.h>

namespace pliant::testing_states {

/// Four times the digits of the laws' double: differences and textbook formulas in it count as exact.
__extension__ typedef __float128 Quad;

using Matrix = Tensor3<double>;

/// The laws of the registry as a type list for typed tests, and their names.
template <class Variant>
struct AlternativesOf;
template <class... L>
struct AlternativesOf<std::variant<L...>> {
  using type = ::testing::Types<L...>;
};

struct NameOfLaw {
  template <class L>
  static std::string GetName(int) {
    return std::string(L::name);
  }
};

template <class T>
Tensor3<T> converted(const Matrix& A) {
  return make_tensor([&](int i, int j) { return T(A(i, j)); });
}

template <class T>
T norm_squared(const Tensor3<T>& A) {
  return dot(A, A);
}
template <class T>
double norm(const Tensor3<T>& A) {
  return std::sqrt(static_cast<double>(norm_squared(A)));
}

/// |A - B| / |B|.
template <class T>
double relative_difference(const Matrix& A, const Tensor3<T>& B) {
  return norm(converted<Quad>(A) - make_tensor([&](int i, int j) { return Quad(B(i, j)); })) / norm(B);
}
inline double relative_difference(double a, Quad b) {
  return std::abs(static_cast<double>((a - b) / b));
}

/// Entries uniform in (-size, size).
inline Matrix random_matrix(unsigned seed, double size) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  return make_tensor([&](int, int) { return uniform(engine); });
}

/// exp of the rotation vector (Rodrigues).
inline Matrix rotation(double x, double y, double z) {
  const double angle = std::sqrt(x * x + y * y + z * z);
  const double a = x / angle, b = y / angle, c = z / angle;
  const Matrix W{{0, -c, b, c, 0, -a, -b, a, 0}};
  return add_to_diagonal(std::sin(angle) * W + (1 - std::cos(angle)) * matmul(W, W), 1.0);
}

/// H of F = Q (I + H0).
inline Matrix rotated(const Matrix& Q, const Matrix& H0) {
  return add_to_diagonal(Q + matmul(Q, H0), -1.0);
}

/// H where every law is sound: J well above 0, no symmetry, strains of some tenths.
inline Matrix moderate_state(unsigned seed) {
  return random_matrix(seed, 0.25);
}

template <class L>
L law_of(double youngs_modulus, double poissons_ratio) {
  const Lame c = lame(youngs_modulus, poissons_ratio);
  return L{c.mu, c.lambda};
}

/// 2 atanh(s) = ln((1 + s) / (1 - s)) by its power series.
inline Quad twice_atanh(Quad s) {
  Quad sum = 0;
  Quad power = 2 * s;
  for (int n = 1; n < 200; n += 2) {
    sum += power / n;
    power *= s * s;
  }
  return sum;
}

/// ln x, halved or doubled into (0.7, 1.4) first.
inline Quad log_reference(Quad x) {
  const Quad log_2 = twice_atanh(Quad(1) / 3);
  int doublings = 0;
  for (; x > 1.4; x /= 2) ++doublings;
  for (; x < 0.7; x *= 2) --doublings;
  return doublings * log_2 + twice_atanh((x - 1) / (x + 1));
}

// The energies and stresses of F as textbooks write them, in Quad.

inline Quad textbook_psi(const Linear& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> eps = Quad(0.5) * (H + transpose(H));
  return law.mu * dot(eps, eps) + law.lambda / 2 * trace(eps) * trace(eps);
}
inline Quad textbook_psi(const SaintVenantKirchhoff& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Tensor3<Quad> E = Quad(0.5) * add_to_diagonal(matmul(transpose(F), F), -1);
  return law.mu * dot(E, E) + law.lambda / 2 * trace(E) * trace(E);
}
inline Quad textbook_psi(const NeoHookean& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Quad log_J = log_reference(det(F));
  return law.mu / 2 * (dot(F, F) - 3) - law.mu * log_J + law.lambda / 2 * log_J * log_J;
}

inline Tensor3<Quad> textbook_P(const Linear& law, const Tensor3<Quad>& H) {
  return add_to_diagonal(Quad(law.mu) * (H + transpose(H)), law.lambda * trace(H));
}
inline Tensor3<Quad> textbook_P(const SaintVenantKirchhoff& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Tensor3<Quad> E = Quad(0.5) * add_to_diagonal(matmul(transpose(F), F), -1);
  return matmul(F, add_to_diagonal(Quad(2 * law.mu) * E, law.lambda * trace(E)));
}
inline Tensor3<Quad> textbook_P(const NeoHookean& law, const Tensor3<Quad>& H) {
  const Tensor3<Quad> F = add_to_diagonal(H, 1);
  const Tensor3<Quad> G = Quad(1 / det(F)) * cofactor(F);
  return Quad(law.mu) * (F - G) + Quad(law.lambda * log_reference(det(F))) * G;
}

}  // namespace pliant::testing_states
