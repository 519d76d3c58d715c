/// Angles of joints with whole turns.
#pragma once

#include "model/mechanisms.hpp"
#include "petsc/archive.hpp"

#include <span>

namespace pliant {

/// The angle of a hinge or cylindrical joint in a state of its bodies [rad], with the whole turns of the last accepted
/// state (ModelJoint::angle), from which it differs by half a turn at most.
double angle_of_joint(const ModelJoint& joint, const std::array<RigidPart::RigidState, 2>& bodies);

/// Takes a state as accepted. Collective.
void follow_turns(std::span<const ModelJoint> joints, Vec q, Vec v);

/// Sets all angles to those at the start, 0. Not collective.
void forget_turns(std::span<const ModelJoint> joints);

/// The angles of the last accepted state. Collective.
void keep_turns(std::span<const ModelJoint> joints, Archive& archive);

}  // namespace pliant
