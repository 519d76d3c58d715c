#include "energy/rigid/rigid_fit.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

/// The eigenvector of a symmetric matrix for its largest eigenvalue, by Jacobi's rotations (Golub & Van Loan, Matrix
/// Computations, 8.5).
Quaternion largest_eigenvector(Matrix4 N) {
  constexpr int most_sweeps = 20;  // it converges quadratically: five or six
  constexpr double nothing = 1e-20;
  double size = 0.0;
  for (const auto& row : N) {
    for (const double entry : row) size = std::max(size, std::abs(entry));
  }
  Matrix4 V{};
  for (std::size_t i = 0; i < 4; ++i) V[i][i] = 1.0;
  bool is_diagonal = false;
  for (int sweep = 0; sweep < most_sweeps && !is_diagonal; ++sweep) {
    is_diagonal = true;
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (std::abs(N[p][q]) <= nothing * size) continue;
        is_diagonal = false;
        const double tau = (N[q][q] - N[p][p]) / (2.0 * N[p][q]);
        const double t = (tau < 0.0 ? -1.0 : 1.0) / (std::abs(tau) + std::sqrt(1.0 + tau * tau));
        const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
        const auto turn_pair = [&](double& x, double& y) {
          const double old = x;
          x = c * old - s * y;
          y = s * old + c * y;
        };
        for (std::size_t k = 0; k < 4; ++k) turn_pair(N[k][p], N[k][q]);
        for (std::size_t k = 0; k < 4; ++k) turn_pair(N[p][k], N[q][k]);
        for (std::size_t k = 0; k < 4; ++k) turn_pair(V[k][p], V[k][q]);
        N[p][q] = N[q][p] = 0.0;
      }
    }
  }
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (N[i][i] > N[largest][largest]) largest = i;
  }
  return {V[0][largest], V[1][largest], V[2][largest], V[3][largest]};
}

/// The mean positions of the nodes before and after, and the sum of products of the deviations from them.
struct Moments {
  Vector3<double> arm{}, now{};  // from the centre
  Tensor3<double> products{};    // sum (now - mean)(arm - mean)^T
};

Moments moments(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre, Vec u) {
  // Number, sum of arms, of displaced arms, of their products.
  std::array<double, 16> sums{};
  {
    const ConstArrayView displacement(u);
    for (const PetscInt a : nodes) {
      const Vector3<double> arm = layout.position(a) - centre;
      const Vector3<double> now = {arm[0] + displacement[3 * a], arm[1] + displacement[3 * a + 1],
                                   arm[2] + displacement[3 * a + 2]};
      sums[0] += 1.0;
      for (std::size_t i = 0; i < 3; ++i) {
        sums[1 + i] += arm[i];
        sums[4 + i] += now[i];
        for (std::size_t k = 0; k < 3; ++k) sums[7 + 3 * i + k] += now[i] * arm[k];
      }
    }
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, layout.comm));
  const double n = sums[0];
  Moments result;
  result.arm = (1.0 / n) * Vector3<double>{sums[1], sums[2], sums[3]};
  result.now = (1.0 / n) * Vector3<double>{sums[4], sums[5], sums[6]};
  result.products = make_tensor([&](int i, int k) {
    const auto j = static_cast<std::size_t>(i), l = static_cast<std::size_t>(k);
    return sums[7 + 3 * j + l] - n * result.now[j] * result.arm[l];
  });
  return result;
}

/// The translation that belongs to a rotation: now - R arm, which keeps the digits of their small difference.
Placement placed(const Moments& m, const Quaternion& rotation) {
  Placement placement{{}, rotation};
  placement.translation = m.now - m.arm - placement.displacement(m.arm);
  return placement;
}

/// Velocities of the nodes about their mean: means, and the products of arms with arms and with velocities.
struct NodalVelocities {
  Vector3<double> arm{}, velocity{};
  Tensor3<double> inertia{};  // of nodes of mass 1
  Vector3<double> spin{};     // sum r x v
};

NodalVelocities gather_velocities(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                  const Vector3<double>& centre, const Placement& placement, Vec v) {
  // Number; sums of arms, velocities, arms times arms, arms times velocities.
  std::array<double, 25> sums{};
  {
    const ConstArrayView velocity(v);
    for (const PetscInt a : nodes) {
      const Vector3<double> r = turn(placement.rotation, Vector3<double>(layout.position(a)) - centre);
      sums[0] += 1.0;
      for (std::size_t i = 0; i < 3; ++i) {
        sums[1 + i] += r[i];
        sums[4 + i] += velocity[3 * a + static_cast<PetscInt>(i)];
        for (std::size_t k = 0; k < 3; ++k) {
          sums[7 + 3 * i + k] += r[i] * r[k];
          sums[16 + 3 * i + k] += r[i] * velocity[3 * a + static_cast<PetscInt>(k)];
        }
      }
    }
  }
  sum_in_place(layout.comm, sums);
  const double n = sums[0];
  NodalVelocities result;
  result.arm = (1.0 / n) * Vector3<double>{sums[1], sums[2], sums[3]};
  result.velocity = (1.0 / n) * Vector3<double>{sums[4], sums[5], sums[6]};
  const auto central = [&](std::size_t first, const Vector3<double>& b) {
    return make_tensor([&](int i, int k) {
      const auto j = static_cast<std::size_t>(i), l = static_cast<std::size_t>(k);
      return sums[first + 3 * j + l] - n * result.arm[j] * b[l];
    });
  };
  const Tensor3<double> rr = central(7, result.arm), rv = central(16, result.velocity);
  result.inertia = add_to_diagonal(-1.0 * rr, trace(rr));
  result.spin = {rv(1, 2) - rv(2, 1), rv(2, 0) - rv(0, 2), rv(0, 1) - rv(1, 0)};
  return result;
}

}  // namespace

// x_to = t_to + Q (x - t_from) with Q = R_to R_from^-1
Vector3<double> moved_from(const Placement& from, const Placement& to, const Vector3<double>& x) {
  const Quaternion& q = from.rotation;
  const Placement turn{to.translation - from.translation, product(to.rotation, {q[0], -q[1], -q[2], -q[3]})};
  return turn.displacement(x - from.translation);
}

Quaternion rotation_nearest_to(const Tensor3<double>& A) {
  const double x = A(2, 1) - A(1, 2), y = A(0, 2) - A(2, 0), z = A(1, 0) - A(0, 1);
  const double xy = A(1, 0) + A(0, 1), yz = A(2, 1) + A(1, 2), zx = A(0, 2) + A(2, 0);
  const std::array<double, 4> d{A(0, 0) + A(1, 1) + A(2, 2), A(0, 0) - A(1, 1) - A(2, 2), A(1, 1) - A(0, 0) - A(2, 2),
                                A(2, 2) - A(0, 0) - A(1, 1)};
  const Quaternion R =
      largest_eigenvector({{{d[0], x, y, z}, {x, d[1], xy, zx}, {y, xy, d[2], yz}, {z, zx, yz, d[3]}}});
  return product(R, {R[0] < 0.0 ? -1.0 : 1.0, 0.0, 0.0, 0.0});
}

// tr(exp(phi axis)^T A) = c + (tr A - axis . A axis) cos phi + axis . axial(A) sin phi
Quaternion rotation_nearest_to(const Tensor3<double>& A, const Vector3<double>& axis) {
  const Vector3<double> axial = {A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1)};
  return exponential(std::atan2(dot(axis, axial), trace(A) - dot(axis, matvec(A, axis))) * axis);
}

Placement nearest_placement(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre,
                            Vec u) {
  const Moments m = moments(layout, nodes, centre, u);
  return placed(m, rotation_nearest_to(m.products));
}

Placement nearest_placement_about(const Vector3<double>& axis, const NodeLayout& layout,
                                  std::span<const PetscInt> nodes, const Vector3<double>& centre, Vec u) {
  const Moments m = moments(layout, nodes, centre, u);
  return placed(m, rotation_nearest_to(m.products, axis));
}

std::array<Vector3<double>, 2> nearest_velocity(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                                const Vector3<double>& centre, const Placement& placement, Vec v) {
  const NodalVelocities sums = gather_velocities(layout, nodes, centre, placement, v);
  // A^-1 b = cof(A)^T b / det A.
  const Vector3<double> omega = (1.0 / det(sums.inertia)) * matvec(transpose(cofactor(sums.inertia)), sums.spin);
  return {sums.velocity - cross(omega, sums.arm), omega};
}

std::array<Vector3<double>, 2> nearest_velocity_about(const Vector3<double>& axis, const NodeLayout& layout,
                                                      std::span<const PetscInt> nodes, const Vector3<double>& centre,
                                                      const Placement& placement, Vec v) {
  const NodalVelocities sums = gather_velocities(layout, nodes, centre, placement, v);
  const Vector3<double> omega = (dot(axis, sums.spin) / dot(axis, matvec(sums.inertia, axis))) * axis;
  return {sums.velocity - cross(omega, sums.arm), omega};
}

}  // namespace pliant
