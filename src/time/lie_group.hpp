/// Rotations and rigid motions as configuration spaces.
///
/// Coordinates are exponential, q = q_n exp(xi), and velocities those of the body's own frame: with q' = q v^,
/// v = dexp_{-xi} xi'. A method is applied to the equations of (xi, v), an ordinary differential equation in a vector
/// space as long as a step turns by less than pi, and so keeps its order, multistep methods included. (Without dexp,
/// v = xi', every method is of second order at most: the term left out is 1/2 [v, xi], and integrates to
/// dt^3/12 [v, v'] in a step. Measured: dirk33 2.00 instead of 3.00.)
///
/// Sources: Iserles, Munthe-Kaas, Norsett & Zanna 2000, "Lie-group methods" (Acta Numerica 9); Study 1903, "Geometrie
/// der Dynamen" (SE(3) is SO(3) over the dual numbers).
#pragma once

#include "time/rotation.hpp"
#include "time/space.hpp"

#include <span>

namespace pliant {

/// SO(3): a body that rotates about a fixed point. The numbers of a configuration are a unit quaternion, body to space;
/// coordinates are a rotation vector [rad], velocities the angular velocity in the body's frame [rad/s].
struct SO3 {
  static constexpr std::size_t num_numbers = 4;
  static constexpr std::size_t num_coordinates = 3;
  template <class T>
  using Coordinates = std::array<T, num_coordinates>;
  using Configuration = std::span<const double, num_numbers>;

  /// log(a^-1 b).
  static Coordinates<double> difference(Configuration a, Configuration b);
  /// a exp(xi).
  static void retract(Configuration a, const Coordinates<double>& xi, std::span<double, num_numbers> b);
  /// dexp_{-xi} xi_dot.
  template <class T>
  static Coordinates<T> velocity(const Coordinates<T>& xi, const Coordinates<T>& xi_dot) {
    return right_jacobian(xi, xi_dot);
  }
  static Quaternion rotation(Configuration a) { return {a[0], a[1], a[2], a[3]}; }
};

/// SE(3): a body in free motion. The numbers of a configuration are the place of the origin of the body's frame [m] and
/// a unit quaternion, body to space; coordinates and velocities are twists in the body's frame: the angular part
/// ([rad], [rad/s]), then the linear part ([m], [m/s]: the velocity of the origin, seen from the body).
struct SE3 {
  static constexpr std::size_t num_numbers = 7;
  static constexpr std::size_t num_coordinates = 6;
  template <class T>
  using Coordinates = std::array<T, num_coordinates>;
  using Configuration = std::span<const double, num_numbers>;

  static Coordinates<double> difference(Configuration a, Configuration b);
  static void retract(Configuration a, const Coordinates<double>& xi, std::span<double, num_numbers> b);
  /// dexp_{-xi} xi_dot, a series in the bracket of twists. That bracket is the vector product of dual vectors
  /// angular + linear eps, so the series has the sum it has for SO(3), over the dual numbers.
  template <class T>
  static Coordinates<T> velocity(const Coordinates<T>& xi, const Coordinates<T>& xi_dot) {
    const auto dual = [](const Coordinates<T>& a) {
      return Vector3<Dual<T>>{Dual<T>(a[0], a[3]), Dual<T>(a[1], a[4]), Dual<T>(a[2], a[5])};
    };
    const auto v = right_jacobian(dual(xi), dual(xi_dot));
    return {v[0].value, v[1].value, v[2].value, v[0].slope, v[1].slope, v[2].slope};
  }
  static Quaternion rotation(Configuration a) { return {a[3], a[4], a[5], a[6]}; }
};

/// Several bodies, distributed over the ranks: vectors of configurations hold num_numbers per body, vectors of
/// coordinates and of velocities num_coordinates. Results must not alias arguments. No method communicates.
template <class Group>
class LieGroupSpace final : public ConfigurationSpace {
 public:
  void difference(Vec a, Vec b, Vec xi) const override;
  void retract(Vec a, Vec xi, Vec b) const override;
  void velocity(Vec xi, Vec xi_dot, Vec v) const override;
};

extern template class LieGroupSpace<SO3>;
extern template class LieGroupSpace<SE3>;

}  // namespace pliant
