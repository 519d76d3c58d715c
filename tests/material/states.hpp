/// States of deformation and reference values for the tests of the laws.
#pragma once

#include "material/lame.hpp"
#include "material/registry.hpp"
#include "quad.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::testing_states {

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

/// The law's place in the registry.
template <class L>
constexpr std::size_t row_of() {
  return []<std::size_t... i>(std::index_sequence<i...>) {
    return ((std::is_same_v<L, std::variant_alternative_t<i, ElasticLawVariant>> ? i : 0) + ...);
  }
  (std::make_index_sequence<ElasticLaws::size>{});
}

/// The law with typical parameters, each times `scale` if it is a stiffness; fibres lie across all axes.
template <class L>
ElasticLawSpec typical_spec(VolumetricForm form = VolumetricForm::mixed, double scale = 1.0) {
  ElasticLawSpec spec = typical_law(row_of<L>());
  spec.volumetric = form;
  spec.directions = {{{2.0 / 7, 3.0 / 7, 6.0 / 7}, {3.0 / 7, -6.0 / 7, 2.0 / 7}}};
  for (std::size_t p = 0; p < spec.parameters.size(); ++p) {
    if (spec.info().parameters[p].unit == "Pa") spec.parameters[p] *= scale;
  }
  return spec;
}
template <class L>
L typical(VolumetricForm form = VolumetricForm::mixed, double scale = 1.0) {
  return std::get<L>(instantiate(typical_spec<L>(form, scale)));
}

/// The volumetric forms that the law knows; one if it has its own.
template <class L>
std::vector<VolumetricForm> forms_of() {
  if (!traits_of<L>().takes_volumetric_form) return {VolumetricForm::mixed};
  return {VolumetricForm::log, VolumetricForm::quadratic, VolumetricForm::mixed};
}

template <class L>
L law_of(double youngs_modulus, double poissons_ratio) {
  const Lame c = lame(youngs_modulus, poissons_ratio);
  return L{c.mu, c.lambda};
}

// What the tests call of the laws is compiled once, for all laws (laws.cpp): their own functions are always inlined,
// and long. A law is its alternative of the registry's.

double energy(const ElasticLawVariant& law, const Matrix& H);
Matrix stress(const ElasticLawVariant& law, const Matrix& H);
/// What the linearisation at H gives: its stress, and its increment for dH.
struct Linearized {
  Matrix P, dP;
};
Linearized linearized(const ElasticLawVariant& law, const Matrix& H, const Matrix& dH);
/// dP of dH.
Matrix increment(const ElasticLawVariant& law, const Matrix& H, const Matrix& dH);
Tangent<double> stiffness_tensor(const ElasticLawVariant& law, const Matrix& H);
/// The size of the entries of the tangent at rest.
double stiffness(const ElasticLawVariant& law);

/// Principal stretches of a body that is not inverted.
std::array<Quad, 3> stretches_reference(const Tensor3<Quad>& H);
/// The energy of F as textbooks write it (textbook.cpp).
Quad textbook_psi(const ElasticLawVariant& law, const Tensor3<Quad>& H);
/// The stress of that energy; fibres that pull at H do so in its neighbourhood, that of the differences.
Tensor3<Quad> textbook_P(const ElasticLawVariant& law, const Tensor3<Quad>& H);

/// (f(H + h e_p) - f(H - h e_p)) / 2h in Quad, extrapolated once: the error, h^4 and 1e-34 / h, is below 1e-25 of f.
template <class F>
auto central_difference(const F& f, const Tensor3<Quad>& H, std::size_t p) {
  const auto at = [&](Quad h) {
    Tensor3<Quad> right = H, left = H;
    right.a[p] += h;
    left.a[p] -= h;
    return Quad(1 / (2 * h)) * (f(right) - f(left));
  };
  const Quad h = 1e-7;
  return Quad(1) / 3 * (Quad(4) * at(h / 2) - at(h));
}

}  // namespace pliant::testing_states
