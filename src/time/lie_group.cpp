#include "time/lie_group.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <cassert>

namespace pliant {
namespace {

/// The numbers of body k of a vector with n per body.
template <std::size_t n, class T>
std::span<T, n> part(std::span<T> values, std::size_t k) {
  return values.subspan(n * k).template first<n>();
}

template <std::size_t n>
std::array<double, n> copy(std::span<const double, n> values) {
  std::array<double, n> result{};
  std::ranges::copy(values, result.begin());
  return result;
}

Vector3<double> place(SE3::Configuration a) {
  return {a[0], a[1], a[2]};
}

/// The inverse of J_r(-phi), which takes the linear part of a twist to the displacement seen from the body:
/// a - 1/2 phi x a + kappa phi x (phi x a), kappa = (1 - c_1 / (2 c_2)) / theta^2 = (c_3 - 2 c_4) / (2 c_2).
Vector3<double> inverse_left_jacobian(const Vector3<double>& phi, const Vector3<double>& a) {
  const double x = dot(phi, phi);
  const double kappa = (stumpff<3>(x) - 2.0 * stumpff<4>(x)) / (2.0 * stumpff<2>(x));
  const Vector3<double> b = cross(phi, a);
  return a + (kappa * cross(phi, b) - 0.5 * b);
}

}  // namespace

SO3::Coordinates<double> SO3::difference(Configuration a, Configuration b) {
  return logarithm(product(inverse(rotation(a)), rotation(b)));
}

void SO3::retract(Configuration a, const Coordinates<double>& xi, std::span<double, num_numbers> b) {
  std::ranges::copy(product(rotation(a), exponential(xi)), b.begin());
}

// With q = (p, R) and xi = (phi, rho): exp(xi) = (J_r(-phi) rho, exp(phi)).
SE3::Coordinates<double> SE3::difference(Configuration a, Configuration b) {
  const Quaternion back = inverse(rotation(a));
  const Vector3<double> phi = logarithm(product(back, rotation(b)));
  const Vector3<double> rho = inverse_left_jacobian(phi, turn(back, place(b) - place(a)));
  return {phi[0], phi[1], phi[2], rho[0], rho[1], rho[2]};
}

void SE3::retract(Configuration a, const Coordinates<double>& xi, std::span<double, num_numbers> b) {
  const Vector3<double> phi = {xi[0], xi[1], xi[2]}, rho = {xi[3], xi[4], xi[5]};
  std::ranges::copy(place(a) + turn(rotation(a), right_jacobian(-1.0 * phi, rho)), b.begin());
  std::ranges::copy(product(rotation(a), exponential(phi)), b.begin() + 3);
}

template <class Group>
void LieGroupSpace<Group>::difference(Vec a, Vec b, Vec xi) const {
  const ConstArrayView a_view(a), b_view(b);
  const ArrayView xi_view(xi);
  constexpr std::size_t n = Group::num_numbers, d = Group::num_coordinates;
  assert(a_view.span().size() * d == xi_view.span().size() * n);
  for (std::size_t k = 0; k < xi_view.span().size() / d; ++k) {
    std::ranges::copy(Group::difference(part<n>(a_view.span(), k), part<n>(b_view.span(), k)),
                      part<d>(xi_view.span(), k).begin());
  }
}

template <class Group>
void LieGroupSpace<Group>::retract(Vec a, Vec xi, Vec b) const {
  const ConstArrayView a_view(a), xi_view(xi);
  const ArrayView b_view(b);
  constexpr std::size_t n = Group::num_numbers, d = Group::num_coordinates;
  assert(a_view.span().size() * d == xi_view.span().size() * n);
  for (std::size_t k = 0; k < xi_view.span().size() / d; ++k) {
    Group::retract(part<n>(a_view.span(), k), copy(part<d>(xi_view.span(), k)), part<n>(b_view.span(), k));
  }
}

template <class Group>
void LieGroupSpace<Group>::velocity(Vec xi, Vec xi_dot, Vec v) const {
  const ConstArrayView xi_view(xi), xi_dot_view(xi_dot);
  const ArrayView v_view(v);
  constexpr std::size_t d = Group::num_coordinates;
  for (std::size_t k = 0; k < xi_view.span().size() / d; ++k) {
    std::ranges::copy(Group::velocity(copy(part<d>(xi_view.span(), k)), copy(part<d>(xi_dot_view.span(), k))),
                      part<d>(v_view.span(), k).begin());
  }
}

template class LieGroupSpace<SO3>;
template class LieGroupSpace<SE3>;

}  // namespace pliant
