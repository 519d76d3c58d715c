/// The keys of `rigid_bodies[]`, `joints[]` and `tendons[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<RigidBodyConfig> rigid_body_keys();
Section<JointConfig> joint_keys();
Section<TendonConfig> tendon_keys();

}  // namespace pliant
