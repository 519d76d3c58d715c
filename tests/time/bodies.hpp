/// Configurations of bodies on SO(3) and SE(3), spread over the ranks.
#pragma once

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "time/lie_group.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test {

/// Numbers of this rank's bodies; rank 1 has none, the others differ in how many.
inline std::size_t num_bodies() {
  const int rank = pliant::rank(MPI_COMM_WORLD);
  return rank == 1 ? 0 : static_cast<std::size_t>(3 + rank);
}

inline Handle<Vec> zeros(std::size_t size) {
  Handle<Vec> x;
  check(VecCreateMPI(MPI_COMM_WORLD, static_cast<PetscInt>(size), PETSC_DECIDE, x.out()));
  return x;
}

/// The rotation (w, x, y, z) after scaling to unit length.
inline Quaternion unit(const Quaternion& q) {
  return product(q, {1.0, 0.0, 0.0, 0.0});
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed + 100U * static_cast<unsigned>(pliant::rank(MPI_COMM_WORLD))) {}
  double operator()() { return normal_(engine_); }
  template <std::size_t n>
  std::array<double, n> numbers() {
    std::array<double, n> result{};
    for (double& x : result) x = (*this)();
    return result;
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// Of any place and orientation.
template <class Group>
std::array<double, Group::num_numbers> random_configuration(Random& random) {
  std::array<double, Group::num_numbers> result{};
  const Quaternion R = unit(random.numbers<4>());
  std::ranges::copy(R, result.end() - 4);
  for (std::size_t i = 0; i + 4 < result.size(); ++i) result[i] = random();
  return result;
}

/// Of any direction, turning by `angle`.
template <class Group>
std::array<double, Group::num_coordinates> random_coordinates(Random& random, double angle) {
  auto xi = random.numbers<Group::num_coordinates>();
  const double length = std::hypot(xi[0], xi[1], xi[2]);
  for (std::size_t i = 0; i < 3; ++i) xi[i] *= angle / length;
  return xi;
}

template <std::size_t n>
void put(Vec x, std::size_t k, const std::array<double, n>& numbers) {
  const ArrayView view(x);
  for (std::size_t i = 0; i < n; ++i) view[static_cast<PetscInt>(n * k + i)] = numbers[i];
}

template <std::size_t n>
std::array<double, n> numbers_of(Vec x, std::size_t k) {
  const ConstArrayView view(x);
  std::array<double, n> result{};
  for (std::size_t i = 0; i < n; ++i) result[i] = view[static_cast<PetscInt>(n * k + i)];
  return result;
}

template <std::size_t n>
double largest_difference(const std::array<double, n>& a, const std::array<double, n>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Orientation and angular velocity (in the body's frame).
struct Turning {
  Quaternion R;
  Vector3<double> omega;
};

/// Euler's equations I omega' = I omega x omega + moment(R), and R' = R omega^ as an equation of the four numbers of
/// the quaternion: no exponential takes part. By the classical Runge-Kutta method; with 1000 steps per unit of time its
/// error is below 1e-12 for velocities of size one. I: principal moments of inertia.
inline Turning reference_turning(
    const Vector3<double>& I, const Turning& initial, double t,
    const std::function<Vector3<double>(const Quaternion&)>& moment = [](const Quaternion&) {
      return Vector3<double>{};
    }) {
  const int num_steps = std::max(1, static_cast<int>(std::ceil(1000 * std::abs(t))));
  const double h = t / num_steps;
  const auto advanced = [](const Turning& y, double s, const Turning& slope) {
    Turning result;
    for (std::size_t i = 0; i < 4; ++i) result.R[i] = y.R[i] + s * slope.R[i];
    result.omega = y.omega + s * slope.omega;
    return result;
  };
  const auto slope = [&](const Turning& y) {
    const auto& [R, w] = y;
    const Vector3<double> L = {I[0] * w[0], I[1] * w[1], I[2] * w[2]}, M = cross(L, w) + moment(R);
    return Turning{{0.5 * (-R[1] * w[0] - R[2] * w[1] - R[3] * w[2]), 0.5 * (R[0] * w[0] + R[2] * w[2] - R[3] * w[1]),
                    0.5 * (R[0] * w[1] + R[3] * w[0] - R[1] * w[2]), 0.5 * (R[0] * w[2] + R[1] * w[1] - R[2] * w[0])},
                   {M[0] / I[0], M[1] / I[1], M[2] / I[2]}};
  };
  Turning y = initial;
  for (int n = 0; n < num_steps; ++n) {
    const Turning k1 = slope(y), k2 = slope(advanced(y, h / 2, k1)), k3 = slope(advanced(y, h / 2, k2)),
                  k4 = slope(advanced(y, h, k3));
    y = advanced(advanced(advanced(advanced(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    y.R = unit(y.R);
  }
  return y;
}

/// Largest entry of R^T R - 1.
inline double distance_from_orthogonal(const Quaternion& R) {
  const Tensor3<double> A = rotation_matrix(R), E = matmul(transpose(A), A) - identity<double>();
  double largest = 0.0;
  for (const double e : E.a) largest = std::max(largest, std::abs(e));
  return largest;
}

}  // namespace pliant::test
