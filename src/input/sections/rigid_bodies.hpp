/// The keys of `rigid_bodies[]`, `joints[]` and `springs[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<RigidBodyConfig> rigid_body_keys();
/// With units of angles or of travels, as the type of the joint says.
Format<JointConfig> joint();
Section<SpringConfig> spring_keys();

}  // namespace pliant
