#include "energy/rigid/rigid_body.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

namespace pliant {
namespace {

/// A twist (angular, linear), or its dual: (moment, force), (angular momentum, momentum).
template <class T>
struct Pair {
  Vector3<T> angular, linear;
};

/// About a fixed point there is no linear motion.
template <class T>
Pair<T> pair_of(const std::array<T, 3>& a) {
  return {a, {T(0.0), T(0.0), T(0.0)}};
}
template <class T>
Pair<T> pair_of(const std::array<T, 6>& a) {
  return {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}};
}

/// The generalised forces along the coordinates; the reaction at a fixed point does not contribute.
template <class Coordinates, class T>
Coordinates coordinates_of(const Pair<T>& a) {
  if constexpr (std::tuple_size_v<Coordinates> == 3) {
    return a.angular;
  } else {
    return {a.angular[0], a.angular[1], a.angular[2], a.linear[0], a.linear[1], a.linear[2]};
  }
}

/// M v = (I omega + m c x u, m (u - c x omega)).
template <class T>
Pair<T> momentum(const RigidBody& body, const Pair<T>& v) {
  const Vector3<T> c = {body.centre[0], body.centre[1], body.centre[2]};
  return {matvec(body.inertia, v.angular) + body.mass * cross(c, v.linear),
          body.mass * (v.linear - cross(c, v.angular))};
}

template <class T>
Pair<T> weight(const RigidBody& body, const Vector3<T>& gravity) {
  const Vector3<T> c = {body.centre[0], body.centre[1], body.centre[2]};
  return {body.mass * cross(c, gravity), body.mass * gravity};
}

template <std::size_t n>
std::array<double, n> copy(std::span<const double> values, std::size_t k) {
  std::array<double, n> result{};
  std::ranges::copy(values.subspan(n * k, n), result.begin());
  return result;
}

template <std::size_t n>
double squares(const std::array<double, n>& a) {
  double result = 0.0;
  for (const double a_i : a) result += a_i * a_i;
  return result;
}

template <class T, std::size_t n>
std::array<T, n> scaled_difference(double s, const std::array<T, n>& a, const std::array<double, n>& b) {
  std::array<T, n> result{};
  for (std::size_t i = 0; i < n; ++i) result[i] = s * (a[i] - b[i]);
  return result;
}

}  // namespace

template <class Group>
RigidBodies<Group>::RigidBodies(MPI_Comm comm, std::vector<RigidBody> owned, const Vector3<double>& gravity)
    : comm_(comm), bodies_(std::move(owned)), gravity_(gravity), prescribed_(bodies_.size() * num_coordinates, 0) {
  num_unknowns_ = static_cast<PetscInt>(sum(comm, static_cast<PetscInt64>(prescribed_.size())));
}

template <class Group>
Handle<Vec> RigidBodies<Group>::make_vector() const {
  Handle<Vec> x;
  check(VecCreateMPI(comm_, static_cast<PetscInt>(bodies_.size() * num_coordinates), PETSC_DECIDE, x.out()));
  return x;
}

template <class Group>
Handle<Vec> RigidBodies<Group>::make_configuration() const {
  Handle<Vec> q;
  check(VecCreateMPI(comm_, static_cast<PetscInt>(bodies_.size() * Group::num_numbers), PETSC_DECIDE, q.out()));
  return q;
}

template <class Group>
Handle<Mat> RigidBodies<Group>::make_hessian() const {
  constexpr auto n = static_cast<PetscInt>(num_coordinates);
  const auto size = static_cast<PetscInt>(prescribed_.size());
  Handle<Mat> K;
  check(MatCreateAIJ(comm_, size, size, PETSC_DETERMINE, PETSC_DETERMINE, n, nullptr, 0, nullptr, K.out()));
  return K;
}

template <class Group>
StagePoint RigidBodies<Group>::enter(const StagePoint& stage, Vec q, Vec xi) {
  begin_stage(stage);
  check(VecCopy(q, xi));
  return stage;
}

template <class Group>
void RigidBodies<Group>::begin_stage(const StagePoint& stage) {
  assert(stage.centre != nullptr);
  const ConstArrayView q_0(stage.q0), v_0(stage.v0), centre(stage.centre);
  dt_ = stage.dt;
  xi_0_.resize(bodies_.size());
  v_0_.resize(bodies_.size());
  body_gravity_.resize(bodies_.size());
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    xi_0_[k] = copy<num_coordinates>(q_0.span(), k);
    v_0_[k] = copy<num_coordinates>(v_0.span(), k);
    const auto q_n = copy<Group::num_numbers>(centre.span(), k);
    body_gravity_[k] = turn(inverse(Group::rotation(q_n)), gravity_);
  }
}

template <class Group>
template <class T>
auto RigidBodies<Group>::forces(std::size_t k, const Coordinates<T>& xi) const -> Forces<T> {
  const RigidBody& body = bodies_[k];
  const Coordinates<T> v = Group::velocity(xi, scaled_difference(1.0 / dt_, xi, xi_0_[k]));
  const Coordinates<T> a = scaled_difference(1.0 / dt_, v, v_0_[k]);
  const auto [omega, u] = pair_of(v);
  const auto [l, p] = momentum(body, pair_of(v));
  const Vector3<T> back = {-xi[0], -xi[1], -xi[2]};
  const Vector3<T> g_n = {body_gravity_[k][0], body_gravity_[k][1], body_gravity_[k][2]};
  return {coordinates_of<Coordinates<T>>(momentum(body, pair_of(a))),
          coordinates_of<Coordinates<T>>(Pair<T>{cross(omega, l) + cross(u, p), cross(omega, p)}),
          coordinates_of<Coordinates<T>>(weight(body, turn(back, g_n)))};
}

template <class Group>
double RigidBodies<Group>::value(Vec q) {
  const ConstArrayView xi(q);
  const bool is_finite = std::ranges::all_of(xi.span(), [](double x) { return std::isfinite(x); });
  return any_rank(comm_, !is_finite) ? std::numeric_limits<double>::infinity() : 0.0;
}

template <class Group>
void RigidBodies<Group>::gradient(Vec q, Vec r) {
  const ConstArrayView xi(q);
  const ArrayView rows(r);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const auto f = forces(k, copy<num_coordinates>(xi.span(), k));
    for (std::size_t i = 0; i < num_coordinates; ++i) {
      rows.span()[num_coordinates * k + i] = f.inertia[i] + f.gyroscopic[i] - f.weight[i];
    }
  }
}

template <class Group>
void RigidBodies<Group>::hessian(Vec q, Mat K, Projection projection) {
  constexpr std::size_t n = num_coordinates;
  const ConstArrayView xi(q);
  PetscInt first = 0;
  check(MatGetOwnershipRange(K, &first, nullptr));
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    std::array<double, n * n> block{};
    const auto xi_k = copy<n>(xi.span(), k);
    for (std::size_t j = 0; j < n; ++j) {
      Coordinates<double> column{};
      if (projection == Projection::positive_semidefinite) {
        Coordinates<double> direction{};
        direction[j] = 1.0 / (dt_ * dt_);
        column = coordinates_of<Coordinates<double>>(momentum(bodies_[k], pair_of(direction)));
      } else {
        Coordinates<Dual<double>> moved{};
        for (std::size_t i = 0; i < n; ++i) moved[i] = Dual<double>(xi_k[i], i == j ? 1.0 : 0.0);
        const auto f = forces(k, moved);
        for (std::size_t i = 0; i < n; ++i) column[i] = (f.inertia[i] + f.gyroscopic[i] - f.weight[i]).slope;
      }
      for (std::size_t i = 0; i < n; ++i) block[n * i + j] = column[i];
    }
    std::array<PetscInt, n> rows{};
    for (std::size_t i = 0; i < n; ++i) rows[i] = first + static_cast<PetscInt>(n * k + i);
    check(MatSetValues(K, n, rows.data(), n, rows.data(), block.data(), INSERT_VALUES));
  }
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

// |phi + alpha d| = 2 pi
template <class Group>
double RigidBodies<Group>::max_step(Vec q, Vec d) {
  constexpr double limit = 4.0 * std::numbers::pi * std::numbers::pi;
  const ConstArrayView xi(q), direction(d);
  double mine = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const auto phi = pair_of(copy<num_coordinates>(xi.span(), k)).angular;
    const auto delta = pair_of(copy<num_coordinates>(direction.span(), k)).angular;
    const double a = dot(delta, delta), b = dot(phi, delta), c = dot(phi, phi) - limit;
    if (a > 0.0 && c < 0.0) mine = std::min(mine, -c / (b + std::sqrt(b * b - a * c)));
  }
  return minimum(comm_, mine);
}

template <class Group>
double RigidBodies<Group>::force_scale(Vec q) {
  const ConstArrayView xi(q);
  double inertia = 0.0, gyroscopic = 0.0, weight = 0.0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const auto f = forces(k, copy<num_coordinates>(xi.span(), k));
    inertia += squares(f.inertia);
    gyroscopic += squares(f.gyroscopic);
    weight += squares(f.weight);
  }
  return std::sqrt(sum(comm_, inertia)) + std::sqrt(sum(comm_, gyroscopic)) + std::sqrt(sum(comm_, weight));
}

// The differences in v and a lose the rounding errors of their terms.
template <class Group>
double RigidBodies<Group>::rounding_floor(Vec q) const {
  const ConstArrayView xi(q);
  double mine = 0.0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const auto rounding = [&](double s, const Coordinates<double>& a) {
      return squares(coordinates_of<Coordinates<double>>(momentum(bodies_[k], pair_of(scaled_difference(s, a, {})))));
    };
    mine += rounding(1.0 / (dt_ * dt_), copy<num_coordinates>(xi.span(), k)) + rounding(1.0 / (dt_ * dt_), xi_0_[k]) +
            rounding(1.0 / dt_, v_0_[k]);
  }
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum(comm_, mine));
}

template <class Group>
double RigidBodies<Group>::energy(Vec q, Vec v) const {
  const ConstArrayView configurations(q), velocities(v);
  double mine = 0.0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const RigidBody& body = bodies_[k];
    const auto q_k = copy<Group::num_numbers>(configurations.span(), k);
    const auto v_k = pair_of(copy<num_coordinates>(velocities.span(), k));
    const auto mu = momentum(body, v_k);
    Vector3<double> centre = turn(Group::rotation(q_k), body.centre);
    if constexpr (std::is_same_v<Group, SE3>) centre = centre + Vector3<double>{q_k[0], q_k[1], q_k[2]};
    mine += 0.5 * (dot(v_k.angular, mu.angular) + dot(v_k.linear, mu.linear)) - body.mass * dot(gravity_, centre);
  }
  return sum(comm_, mine);
}

template class RigidBodies<SO3>;
template class RigidBodies<SE3>;

}  // namespace pliant
