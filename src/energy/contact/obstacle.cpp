#include "energy/contact/obstacle.hpp"

#include <algorithm>

namespace pliant {

ObstacleFrame::ObstacleFrame(const SignedDistance& shape, const Vector3<double>& centre, const Placement& placement)
    : shape_(shape),
      shape_centre_(centre),
      centre_(centre + placement.translation),
      rotation_(rotation_matrix(placement.rotation)),
      back_(transpose(rotation_)) {}

void ObstacleFrame::set_velocity(const Vector3<double>& velocity, const Vector3<double>& spin) {
  velocity_ = velocity;
  spin_ = spin;
}

DistanceAt ObstacleFrame::at(const Vector3<double>& x) const {
  const DistanceAt s = shape_.at(in_shape(x));
  return {s.d, matvec(rotation_, s.n), matmul(rotation_, matmul(s.curvature, back_))};
}

Obstacle::Obstacle(std::shared_ptr<const SignedDistance> shape, const RigidMotion& motion)
    : shape_(std::move(shape)), motion_(motion), translation_{motion.translation}, angle_{{motion.angle}} {}

bool Obstacle::moves() const {
  const auto is_zero = [](const std::optional<Expression>& component) { return !component || component->is_zero(); };
  return !motion_.angle.is_zero() || !std::ranges::all_of(motion_.translation, is_zero);
}

ObstacleFrame Obstacle::at(const Instant& instant) const {
  return {*shape_, motion_.centre, motion_.at(instant.time, instant.load_factor)};
}

ObstacleFrame Obstacle::at(const Instant& instant, double time_scale) const {
  ObstacleFrame frame = at(instant);
  if (!moves()) return frame;
  const GivenKinematics centre(translation_, instant.time, time_scale, instant.load_factor),
      angle(angle_, instant.time, time_scale, instant.load_factor);
  frame.set_velocity({centre(0, {}).v, centre(1, {}).v, centre(2, {}).v}, angle(0, {}).v * motion_.axis);
  return frame;
}

}  // namespace pliant
