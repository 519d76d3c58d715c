/// The springs, dampers, motors, stops and friction of the input's joints.
#pragma once

#include "energy/rigid/joint_effort.hpp"
#include "input/config.hpp"
#include "model/mechanisms.hpp"

#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace pliant {

struct JointEfforts {
  std::vector<std::unique_ptr<EnergyTerm>> terms;  ///< one for each kind of law that joints have
  std::vector<std::vector<JointLaw>> laws;         ///< of each joint
};
/// `config`: with all rigid bodies. Throws InputError at a joint whose bodies are parts of soft ones. In a static
/// analysis rates do nothing. Collective.
JointEfforts make_joint_efforts(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                                std::span<const ModelJoint> joints);

/// The ending of the column of what a law exerts: `_spring`, `_damping`, `_effort` of a motor, `_stops`, `_friction`,
/// `_bearing`.
std::string_view ending_of(const JointLaw& law);

/// Throws InputError at a formula of a joint or tendon that is not finite at the time [s].
void require_finite_formulas(const Config& config, double time);

}  // namespace pliant
