/// Obstacles: rigid solids of given shape and motion, which bodies touch.
#pragma once

#include "energy/given_motion.hpp"
#include "energy/term.hpp"
#include "fem/signed_distance.hpp"

#include <memory>

namespace pliant {

/// An obstacle at one instant.
class ObstacleFrame {
 public:
  /// `velocity` and `spin` [1/s] are those of the motion's centre and of the body. `shape` outlives the object.
  ObstacleFrame(const SignedDistance& shape, const Vector3<double>& centre, const Placement& placement);
  void set_velocity(const Vector3<double>& velocity, const Vector3<double>& spin);

  DistanceAt at(const Vector3<double>& x) const;
  double distance(const Vector3<double>& x) const { return shape_.distance(in_shape(x)); }
  /// Velocity of the obstacle's material point at x [m/s].
  Vector3<double> velocity(const Vector3<double>& x) const { return velocity_ + cross(spin_, x - centre_); }
  /// The point of the reference shape that is at x.
  Vector3<double> in_shape(const Vector3<double>& x) const { return shape_centre_ + matvec(back_, x - centre_); }
  /// The position of a point of the shape.
  Vector3<double> place(const Vector3<double>& X) const { return centre_ + matvec(rotation_, X - shape_centre_); }

 private:
  const SignedDistance& shape_;
  Vector3<double> shape_centre_, centre_;  // of the motion: where the shape is given, and now
  Tensor3<double> rotation_, back_;        // R, R^T
  Vector3<double> velocity_{}, spin_{};
};

/// A shape and how it moves: x = centre + translation + R (X - centre).
class Obstacle {
 public:
  /// Whether all components of the motion's translation are prescribed.
  Obstacle(std::shared_ptr<const SignedDistance> shape, const RigidMotion& motion);

  /// At an instant, without velocities.
  ObstacleFrame at(const Instant& instant) const;
  /// At an instant, with the velocities just before it; `time_scale`: the motion is smooth over this time
  /// (GivenKinematics).
  ObstacleFrame at(const Instant& instant, double time_scale) const;
  /// Whether it moves, in time or with the load factor.
  bool moves() const;
  const SignedDistance& shape() const { return *shape_; }

 private:
  std::shared_ptr<const SignedDistance> shape_;
  RigidMotion motion_;
  GivenDisplacement translation_, angle_;  // the latter as a first component
};

}  // namespace pliant
