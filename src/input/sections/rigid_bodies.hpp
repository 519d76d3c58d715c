/// The keys of `rigid_bodies[]`, `joints[]`, `tendons[]` and `springs[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<RigidBodyConfig> rigid_body_keys();
Section<JointConfig> joint_keys();
Section<TendonConfig> tendon_keys();
Section<SpringConfig> spring_keys();

}  // namespace pliant
