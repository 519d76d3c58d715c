/// Rigid bodies: the equation of a stage by Newton and Euler, in body frames.
///
/// With the twist v = (omega, u) of a body's frame, its mass matrix M, momentum mu = M v and weight w, all in the
/// body's frame, the residual per body is
///
///     r(xi) = M a + ad*(v) mu - w,     v = dexp_{-xi} (xi - xi_0)/dt_i,   a = (v - v_0)/dt_i,
///     ad*(v) (l, p) = (omega x l + u x p, omega x p)
///
/// (Marsden & Ratiu, Introduction to Mechanics and Symmetry, chapter 14). It is not the gradient of a function of xi:
/// only M a would be, in a vector space. The unknowns are the coordinates xi around the configuration `centre` of the
/// stage.
#pragma once

#include "energy/stage_equation.hpp"
#include "time/lie_group.hpp"

#include <array>
#include <vector>

namespace pliant {

/// In the body's frame. The origin of that frame is the fixed point (SO3), or any point of the body (SE3).
struct RigidBody {
  double mass = 0.0;          ///< [kg]
  Vector3<double> centre{};   ///< of mass [m]
  Tensor3<double> inertia{};  ///< about the origin, not about the centre of mass [kg m^2]
};

/// Bodies without interaction, in a field of gravity: about fixed points (SO3) or in free motion (SE3). Vectors as in
/// LieGroupSpace; norms that add moments and forces measure lengths in metres.
template <class Group>
class RigidBodies final : public StageEquation {
 public:
  static constexpr std::size_t num_coordinates = Group::num_coordinates;

  /// This rank owns `owned`, which may be empty. `gravity` is in space [m/s^2]. Collective.
  RigidBodies(MPI_Comm comm, std::vector<RigidBody> owned, const Vector3<double>& gravity);

  void begin_stage(const StagePoint& stage);
  StagePoint enter(const StagePoint& stage, Vec q, Vec xi) override;
  /// 0 (no term is a potential); +inf where a coordinate is not finite.
  double value(Vec q) override;
  void gradient(Vec q, Vec r) override;
  Handle<Mat> make_hessian() const override;
  /// Exact, or projected to M/dt_i^2, the inertia at small coordinates.
  void hessian(Vec q, Mat K, Projection projection) override;
  /// The step to the first body that would rotate by 2 pi, where its coordinates end.
  double max_step(Vec q, Vec d) override;
  double force_scale(Vec q) override;
  double rounding_floor(Vec q) const override;
  std::vector<std::string> non_potentials() const override { return {"Newton-Euler inertia"}; }
  Symmetry symmetry() const override { return Symmetry::unsymmetric; }
  const std::vector<char>& prescribed() const override { return prescribed_; }
  PetscInt num_unknowns() const override { return num_unknowns_; }
  MPI_Comm comm() const override { return comm_; }
  Handle<Vec> make_vector() const override;

  /// A zero vector of configurations; not a valid configuration until quaternions are set.
  Handle<Vec> make_configuration() const;
  /// Kinetic energy plus the potential energy of gravity, relative to the origin of space [J]. Collective.
  double energy(Vec q, Vec v) const;

 private:
  template <class T>
  using Coordinates = typename Group::template Coordinates<T>;
  /// The three parts of r.
  template <class T>
  struct Forces {
    Coordinates<T> inertia, gyroscopic, weight;
  };
  template <class T>
  Forces<T> forces(std::size_t k, const Coordinates<T>& xi) const;

  MPI_Comm comm_;
  std::vector<RigidBody> bodies_;
  Vector3<double> gravity_;
  std::vector<char> prescribed_;
  PetscInt num_unknowns_ = 0;
  // State of the current stage.
  double dt_ = 0.0;
  std::vector<Coordinates<double>> xi_0_, v_0_;
  std::vector<Vector3<double>> body_gravity_;  // at the centre of the coordinates, seen from the bodies
};

extern template class RigidBodies<SO3>;
extern template class RigidBodies<SE3>;

}  // namespace pliant
