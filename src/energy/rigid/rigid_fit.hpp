/// The rigid motion that is nearest to the motion of some nodes.
#pragma once

#include "energy/given_motion.hpp"
#include "fem/layout.hpp"

#include <array>
#include <span>

namespace pliant {

/// Minimises sum |X + u - x(X)|^2 over the placements of a rigid body, all nodes weighing the same. `nodes`: owned
/// ones; `centre`: of the placement [m]. The rotation of nodes on one line is arbitrary about that line. Source: Horn
/// 1987, "Closed-form solution of absolute orientation using unit quaternions". Collective.
Placement nearest_placement(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre,
                            Vec u);

/// The same with a rotation about an axis (of unit length) alone.
Placement nearest_placement_about(const Vector3<double>& axis, const NodeLayout& layout,
                                  std::span<const PetscInt> nodes, const Vector3<double>& centre, Vec u);

/// The velocity of the centre and the angular velocity that are nearest to the velocities v of the nodes of a body at a
/// placement. Collective.
std::array<Vector3<double>, 2> nearest_velocity(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                                const Vector3<double>& centre, const Placement& placement, Vec v);

/// The same with an angular velocity about an axis (of unit length) alone.
std::array<Vector3<double>, 2> nearest_velocity_about(const Vector3<double>& axis, const NodeLayout& layout,
                                                      std::span<const PetscInt> nodes, const Vector3<double>& centre,
                                                      const Placement& placement, Vec v);

/// How far the rigid motion from one placement to another, both about the same centre at the origin, moves the point
/// that is now at `x`.
Vector3<double> moved_from(const Placement& from, const Placement& to, const Vector3<double>& x);

/// The rotation R that makes tr(R^T A) largest.
Quaternion rotation_nearest_to(const Tensor3<double>& A);
/// The same among the rotations about an axis of unit length.
Quaternion rotation_nearest_to(const Tensor3<double>& A, const Vector3<double>& axis);

}  // namespace pliant
