/// The keys of `rigid_bodies[]`, `joints[]` and `springs[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<RigidBodyConfig> rigid_body_keys();
Section<JointConfig> joint_keys();
Section<SpringConfig> spring_keys();

}  // namespace pliant
