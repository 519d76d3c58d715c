#include "model/joint_turns.hpp"

#include <cmath>
#include <numbers>

namespace pliant {
namespace {

/// The angle by which R turns about the axis, up to whole turns.
double angle_about(const Vector3<double>& axis, const Quaternion& R) {
  return 2.0 * std::atan2(R[1] * axis[0] + R[2] * axis[1] + R[3] * axis[2], R[0]);
}

}  // namespace

double angle_of_joint(const ModelJoint& joint, const std::array<RigidPart::RigidState, 2>& bodies) {
  const Quaternion turned = product(inverse(bodies[0].at.rotation), bodies[1].at.rotation);
  return nearest_turn(angle_about(joint.axis, turned), *joint.angle);
}

void follow_turns(std::span<const ModelJoint> joints, Vec q, Vec v) {
  for (const ModelJoint& joint : joints) {
    if (joint.angle != nullptr) *joint.angle = angle_of_joint(joint, joint.mechanism->states(joint.bodies, q, v));
  }
}

void forget_turns(std::span<const ModelJoint> joints) {
  for (const ModelJoint& joint : joints) {
    if (joint.angle != nullptr) *joint.angle = 0.0;
  }
}

void keep_turns(std::span<const ModelJoint> joints, Archive& archive) {
  for (const ModelJoint& joint : joints) {
    if (joint.angle != nullptr) archive.number(joint.name, *joint.angle);
  }
}

}  // namespace pliant
