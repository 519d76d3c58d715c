/// The keys of `rigid_bodies[]` and `joints[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<RigidBodyConfig> rigid_body_keys();
Section<JointConfig> joint_keys();

}  // namespace pliant
